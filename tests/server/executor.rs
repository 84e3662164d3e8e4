//! An executor that draws nothing but a colour made from the plan, fails when it is told to, and can be held.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Condvar, Mutex};
use std::time::Duration;
use stormdeck::frame::Pixels;
use stormdeck::plan::FramePlan;
use stormdeck::plan::executor::{Executor, Fault, Finished};
use stormdeck::serve::ExecutorFactory;

/// What happens instead of drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trouble {
    DeviceLost,
    Unsupported,
    Panic,
}

/// What a test sees of its executors and tells them.
#[derive(Default)]
pub struct Control {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    submitted: u64,
    made: u64,
    held: bool,
    trouble_at: BTreeMap<u64, Trouble>,
    fail_to_make: u64,
    rejected_px: Option<[u32; 2]>,
}

impl Control {
    /// Pictures asked for so far, by all executors.
    pub fn submitted(&self) -> u64 {
        self.state.lock().unwrap().submitted
    }

    /// Executors made so far.
    pub fn made(&self) -> u64 {
        self.state.lock().unwrap().made
    }

    /// The next picture but `later` meets this trouble.
    pub fn trouble(&self, later: u64, trouble: Trouble) {
        let mut state = self.state.lock().unwrap();
        let at = state.submitted + 1 + later;
        state.trouble_at.insert(at, trouble);
    }

    /// Pictures of this size are rejected from now on, each time.
    pub fn reject(&self, size_px: [u32; 2]) {
        self.state.lock().unwrap().rejected_px = Some(size_px);
    }

    /// The next so many executors cannot be made.
    pub fn fail_to_make(&self, times: u64) {
        self.state.lock().unwrap().fail_to_make = times;
    }

    /// No picture is finished until [`Control::release`].
    pub fn hold(&self) {
        self.state.lock().unwrap().held = true;
    }

    pub fn release(&self) {
        self.state.lock().unwrap().held = false;
        self.changed.notify_all();
    }

    pub fn factory(self: &Arc<Self>) -> ExecutorFactory {
        let control = Arc::clone(self);
        Box::new(move || {
            let mut state = control.state.lock().unwrap();
            if state.fail_to_make > 0 {
                state.fail_to_make -= 1;
                return Err(Fault::NoAdapter);
            }
            state.made += 1;
            Ok(Box::new(Painter { control: Arc::clone(&control), under_way: VecDeque::new() }))
        })
    }
}

struct Painter {
    control: Arc<Control>,
    under_way: VecDeque<(u64, FramePlan, Option<Trouble>)>,
}

impl Executor for Painter {
    fn describe(&self) -> String {
        "painter of the tests".into()
    }

    fn submit(&mut self, ticket: u64, plan: &FramePlan) -> Result<(), Fault> {
        assert!(self.under_way.len() < self.depth(), "more under way than the ring holds");
        let mut state = self.control.state.lock().unwrap();
        state.submitted += 1;
        let submitted = state.submitted;
        let trouble = state.trouble_at.remove(&submitted);
        let rejected = state.rejected_px == Some(plan.size_px);
        drop(state);
        if rejected {
            return Err(Fault::Rejected("too much for the test".into()));
        }
        if trouble == Some(Trouble::Unsupported) {
            return Err(Fault::Unsupported("this very picture".into()));
        }
        self.under_way.push_back((ticket, plan.clone(), trouble));
        Ok(())
    }

    fn collect(&mut self, wait: bool) -> Result<Vec<Finished>, Fault> {
        let mut state = self.control.state.lock().unwrap();
        while state.held {
            if !wait {
                return Ok(Vec::new());
            }
            state = self.control.changed.wait(state).unwrap();
        }
        drop(state);
        let mut finished = Vec::new();
        while let Some((ticket, plan, trouble)) = self.under_way.pop_front() {
            match trouble {
                Some(Trouble::DeviceLost) => return Err(Fault::DeviceLost("pulled by the test".into())),
                Some(Trouble::Panic) => panic!("a panic that the test asked for"),
                _ => finished.push(Finished {
                    ticket,
                    pixels: paint(&plan),
                    provisional: false,
                    read_back: Duration::ZERO,
                }),
            }
        }
        Ok(finished)
    }

    fn depth(&self) -> usize {
        2
    }
}

/// One colour for the whole picture: a hash of the plan.
fn paint(plan: &FramePlan) -> Pixels {
    // FNV-1a over the printed plan: any difference shows.
    let hash = format!("{plan:?}")
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
    let [red, green, blue, ..] = hash.to_le_bytes();
    let [width, height] = plan.size_px;
    Pixels::Srgb8([red, green, blue, 255].repeat(width as usize * height as usize))
}
