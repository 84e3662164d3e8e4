//! One source compiled for several instruction sets, the best one chosen at run time.

use pulp::{Arch, NullaryFnOnce};

/// Runs a kernel with the widest vectors of this machine.
///
/// The kernel must be a closure marked `#[inline(always)]` whose calls are all so marked and that passes no closure on, else
/// what is left out of line is compiled for the oldest machine. Rust never fuses a multiplication with an addition by itself, so all
/// instruction sets round alike.
#[inline(always)]
pub fn vectorised<R>(kernel: impl FnMut() -> R) -> R {
    Arch::new().dispatch(Kernel(kernel))
}

/// Calls through `FnMut`: `FnOnce` would come with a call out of line.
struct Kernel<F>(F);

impl<R, F: FnMut() -> R> NullaryFnOnce for Kernel<F> {
    type Output = R;

    #[inline(always)]
    fn call(mut self) -> R {
        (self.0)()
    }
}
