//! Every field that the pages of `protocol/` call used changes what is drawn or answered, and every field that they call
//! ignored changes nothing: conversations that differ in that field alone are held and compared.

use super::answers::Known;
use super::link::Link;
use super::questions::Questions;
use crate::geo::terrain::Terrain;
use crate::wire::cigi::layout::{Effect, Field, Kind, Place, Value};
use crate::wire::cigi::packets::*;
use crate::wire::cigi::scene::{
    Consequence, Convention, EVENT_STRIKE_MISSED, EVENT_STRIKE_SHOWN, Moment, STRIKE_COMPONENT, Scene,
};
use crate::wire::cigi::{ByteOrder, Direction, Message, Version, decode, encode};
use crate::world::World;
use crate::world::command::Command;
use std::fmt::Write as _;
use std::sync::Arc;

mod talks;

use talks::{Talk, talks};

/// Fields whose every other value makes the message another version's, or none at all.
const VERSION_FIELDS: [&str; 3] = ["major_version", "minor_version", "byte_swap_magic"];

/// What came of a conversation.
#[derive(PartialEq)]
struct Outcome {
    /// All that was commanded, drawn, answered and sent.
    seen: String,
    /// Messages rejected and packets refused.
    refused: usize,
}

/// Holds a conversation with this packet in its place.
fn hold(version: Version, talk: &Talk, packet: &Packet) -> Outcome {
    let convention = Convention { sea_level_m: 48.0, seed: 1, size_px: [64, 36], terrain: Terrain::procedural() };
    let (mut scene, mut link, mut world) = (Scene::new(convention), Link::new(true), World::new());
    let mut outcome = Outcome { seen: String::new(), refused: 0 };
    let mut questions = Questions::default();
    for (number, packets) in talk.messages(version, packet).into_iter().enumerate() {
        let message = Message { version, byte_order: ByteOrder::Little, packets, skipped: Vec::new() };
        let bytes = encode(&message).expect("in range");
        let message = match decode(&bytes) {
            Ok(message) => message,
            Err(rejected) => {
                let _ = writeln!(outcome.seen, "{rejected}");
                outcome.refused += 1;
                continue;
            }
        };
        let Some(Packet::IgControl(control)) = message.packets.first() else { panic!("IG Control comes first") };
        let heard = link.hear(control);
        let start = link.start_of_frame(version, 1_000 * number as u64, false, false);
        let _ = writeln!(outcome.seen, "{heard:?} {start:?}");
        let moment = Moment {
            host_frame: control.host_frame_number,
            timestamp: control.timestamp_valid.then_some(control.timestamp),
            extrapolate: control.extrapolation_interpolation_enable,
            now_s: 0.0,
        };
        for consequence in scene.take(&message, &moment) {
            let applied = match consequence {
                Consequence::Command(command) => world.apply(command).map(|_| ()),
                Consequence::Strike { strike_id, request } => {
                    let _ = writeln!(outcome.seen, "{strike_id} {request:?}");
                    world.apply(Command::Strike(request)).map(|_| ())
                }
                Consequence::Question(question) => {
                    assert!(questions.ask(question));
                    Ok(())
                }
                Consequence::Refused(refused) => Err(refused),
            };
            if let Err(refused) = applied {
                let _ = writeln!(outcome.seen, "{refused}");
                outcome.refused += 1;
            }
        }
    }
    let wanted = [EVENT_STRIKE_SHOWN, EVENT_STRIKE_MISSED].map(|event| scene.wants(event));
    let now = world.peek(0.02);
    world.advance_to(0.5);
    let _ = writeln!(outcome.seen, "{wanted:?} {now:?} {:?}", world.peek(0.02));
    let known = Known {
        snapshot: Arc::new(now),
        entities: scene.entities().clone(),
        air: scene.air(),
        host_frame_number_lsn: (link.host_frame() & 0xf) as u8,
    };
    for frame in 1..=2 {
        for question in questions.due(frame, scene.entities()) {
            let _ = writeln!(outcome.seen, "frame {frame}: {:?}", known.answer(&question));
        }
    }
    outcome
}

/// Other values that a field may have.
fn others(field: &Field, place: Place, value: &Value) -> Vec<Value> {
    match value {
        Value::Whole(value) => {
            let [least, most] = field.kind.range(place);
            let mut whole = vec![0, 1, 2, 3, 4, value + 1, value - 1, 12, most];
            // A 32-bit word may hold a float: another exponent is another number by far.
            if field.kind == Kind::U32 {
                whole.push(value ^ 0x0080_0000);
            }
            whole.sort_unstable();
            whole.dedup();
            whole.retain(|other| other != value && (least..=most).contains(other));
            whole.into_iter().map(Value::Whole).collect()
        }
        Value::Single(value) => [value + 1.0, value * 0.5 + 0.25, 0.0].map(Value::Single).to_vec(),
        Value::Double(value) => [value + 1.0, value * 0.5 + 0.25, 0.0].map(Value::Double).to_vec(),
        Value::Text(text) => vec![Value::Text(format!("{text}x"))],
    }
}

#[test]
fn every_field_of_a_host_has_the_effect_that_its_page_says() {
    let mut wrong = Vec::new();
    let (mut used, mut ignored) = (0, 0);
    for version in Version::ALL {
        let talks = talks(version);
        for layout in LAYOUTS.iter().filter(|layout| layout.direction == Direction::HostToIg) {
            let of_packet: Vec<&Talk> =
                talks.iter().filter(|talk| talk.packet.layout().type_name == layout.type_name).collect();
            assert_eq!(of_packet.is_empty(), layout.framing(version).is_none(), "{}", layout.type_name);
            let plain: Vec<Outcome> = of_packet.iter().map(|talk| hold(version, talk, &talk.packet)).collect();
            for (talk, plain) in of_packet.iter().zip(&plain) {
                assert_eq!(plain.refused, 0, "{}: {}", talk.packet.layout().name, plain.seen);
            }
            for (index, field, place, name) in layout.placed(version) {
                // Whether a change of this field alone changes what is seen, and is not merely refused.
                let changes = |talk: &Talk, plain: &Outcome| {
                    let value = talk.packet.field(index).expect("a field");
                    others(field, place, &value).into_iter().any(|other| {
                        let mut packet = talk.packet.clone();
                        assert!(packet.set_field(index, &other));
                        let found = hold(version, talk, &packet);
                        found != *plain && (found.refused == 0 || VERSION_FIELDS.contains(&name))
                    })
                };
                let effect = of_packet.iter().zip(&plain).any(|(talk, plain)| changes(talk, plain));
                let says = matches!(field.effect, Effect::Used(_));
                used += usize::from(says);
                ignored += usize::from(!says);
                if effect != says {
                    wrong.push(format!("CIGI {}: {}.{name}: effect {effect}", version.name(), layout.name));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(used > 300 && ignored > 40, "{used} used and {ignored} ignored fields were tried");
}

#[test]
fn a_conversation_that_is_held_again_says_the_same() {
    for talk in talks(Version::V4) {
        let (once, again) = (hold(Version::V4, &talk, &talk.packet), hold(Version::V4, &talk, &talk.packet));
        assert!(once == again && once.seen.len() > 1_000, "{}: {}", talk.packet.layout().name, once.seen);
    }
}
