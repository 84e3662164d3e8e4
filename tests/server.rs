//! The server in process on port 0, with a trivial executor whose pictures depend on the plan alone.
//!
//! What is pinned here: who may do what, that refusals change nothing, that slow, stuck and vanished clients harm nobody
//! else, that lockstep loses nothing and keeps its order, that faults are survived, and that a stop leaves nothing behind.
//! Deadlines are guards against hanging; no assertion is about how long something took.

#[path = "server/executor.rs"]
mod executor;
#[path = "server/harness.rs"]
mod harness;
#[path = "tshark/mod.rs"]
mod tshark;

#[path = "server/access.rs"]
mod access;
#[path = "server/answers.rs"]
mod answers;
#[path = "server/cigi.rs"]
mod cigi;
#[path = "server/every_field/mod.rs"]
mod every_field;
#[path = "server/faults.rs"]
mod faults;
#[path = "server/frames.rs"]
mod frames;
#[path = "server/lockstep.rs"]
mod lockstep;
#[path = "server/messages.rs"]
mod messages;
#[path = "server/pictures.rs"]
mod pictures;
#[path = "server/roles.rs"]
mod roles;
#[path = "server/stop.rs"]
mod stop;
#[path = "server/strikes.rs"]
mod strikes;
