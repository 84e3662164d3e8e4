//! The host role: one client at a time steers the world, all others watch.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Number of a connection, rising, never used again.
pub(super) type ClientId = u64;

/// Who is host.
#[derive(Default)]
pub(super) struct Roles {
    host: Mutex<Option<(ClientId, String)>>,
}

/// What became of a wish to be host.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Claim {
    /// The role was free, or the client had it already.
    Granted,
    /// Taken from this client, which must be told.
    TakenFrom(ClientId),
    /// Somebody of this name has it.
    Held(String),
}

impl Roles {
    /// `override_it`: takes the role from whoever has it.
    pub(super) fn claim(&self, client: ClientId, name: &str, override_it: bool) -> Claim {
        let mut host = self.lock();
        let previous = host.as_ref().filter(|(holder, _)| *holder != client);
        let claim = match previous {
            Some((_, holder_name)) if !override_it => return Claim::Held(holder_name.clone()),
            Some((holder, _)) => Claim::TakenFrom(*holder),
            None => Claim::Granted,
        };
        *host = Some((client, name.to_owned()));
        claim
    }

    /// Gives the role back if this client has it. True when it had it.
    pub(super) fn release(&self, client: ClientId) -> bool {
        let mut host = self.lock();
        let had = host.as_ref().is_some_and(|(holder, _)| *holder == client);
        if had {
            *host = None;
        }
        had
    }

    /// Whether this client is host.
    pub(super) fn is_host(&self, client: ClientId) -> bool {
        self.lock().as_ref().is_some_and(|(holder, _)| *holder == client)
    }

    /// The host's number.
    pub(super) fn host_id(&self) -> Option<ClientId> {
        self.lock().as_ref().map(|(holder, _)| *holder)
    }

    /// The host's name.
    pub(super) fn host_name(&self) -> Option<String> {
        self.lock().as_ref().map(|(_, name)| name.clone())
    }

    fn lock(&self) -> MutexGuard<'_, Option<(ClientId, String)>> {
        self.host.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_hosts_cannot_have_one_ownship() {
        let roles = Roles::default();
        assert_eq!(roles.claim(1, "first", false), Claim::Granted);
        assert_eq!(roles.claim(1, "first", false), Claim::Granted);
        assert_eq!(roles.claim(2, "second", false), Claim::Held("first".into()));
        assert!(roles.is_host(1) && !roles.is_host(2));
        assert_eq!(roles.claim(2, "second", true), Claim::TakenFrom(1));
        assert!(!roles.release(1), "the first one has nothing left to give back");
        assert_eq!(roles.host_name(), Some("second".into()));
        assert!(roles.release(2));
        assert_eq!(roles.claim(1, "first", false), Claim::Granted);
    }
}
