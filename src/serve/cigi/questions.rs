//! Questions of a host: asked once, or again and again with every n-th frame.

use crate::wire::cigi::packets::Packet;
use crate::wire::cigi::scene::Entities;
use crate::wire::limits::{CIGI_PERIODIC_QUESTIONS, CIGI_QUESTIONS};
use std::collections::BTreeMap;

/// What the host wants to know.
#[derive(Clone, Debug, Default)]
pub struct Questions {
    once: Vec<Packet>,
    /// By kind and the host's number.
    periodic: BTreeMap<(bool, u16), (Packet, u8)>,
}

impl Questions {
    /// Takes a question. One with a period replaces, and one without ends, a periodic one of the same number. False: there are
    /// too many.
    pub fn ask(&mut self, question: Packet) -> bool {
        let (key, period) = match &question {
            Packet::HatHotRequest(request) => ((false, request.hat_hot_id), request.update_period),
            Packet::LineOfSightSegmentRequest(request) => ((true, request.los_id), request.update_period),
            Packet::LineOfSightVectorRequest(request) => ((true, request.los_id), request.update_period),
            _ => return self.push(question),
        };
        if period == 0 {
            self.periodic.remove(&key);
            return self.push(question);
        }
        if self.periodic.len() >= CIGI_PERIODIC_QUESTIONS && !self.periodic.contains_key(&key) {
            return false;
        }
        self.periodic.insert(key, (question, period));
        true
    }

    fn push(&mut self, question: Packet) -> bool {
        let room = self.once.len() < CIGI_QUESTIONS;
        if room {
            self.once.push(question);
        }
        room
    }

    /// The questions that are due with this frame of ours.
    pub fn due(&mut self, frame: u32, entities: &Entities) -> Vec<Packet> {
        self.periodic.retain(|_, (question, _)| carrier(question).is_none_or(|id| entities.pose(id).is_some()));
        let periodic = self.periodic.values().filter(|(_, period)| frame.is_multiple_of(u32::from(*period)));
        let periodic: Vec<Packet> = periodic.map(|(question, _)| question.clone()).collect();
        self.once.drain(..).chain(periodic).collect()
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        *self = Self::default();
    }
}

/// The entity that a question hangs on: when that is destroyed, a periodic question ends.
fn carrier(question: &Packet) -> Option<u16> {
    match question {
        Packet::HatHotRequest(request) => request.coordinate_system.then_some(request.entity_id),
        Packet::LineOfSightSegmentRequest(request) => {
            request.source_point_coordinate_system.then_some(request.source_entity_id)
        }
        Packet::LineOfSightVectorRequest(request) => {
            request.source_point_coordinate_system.then_some(request.entity_id)
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geo::terrain::Terrain;
    use crate::wire::cigi::packets::{EntityControl, HatHotRequest, LineOfSightVectorRequest};
    use crate::wire::cigi::scene::Moment;

    fn heights(hat_hot_id: u16, update_period: u8) -> Packet {
        HatHotRequest { hat_hot_id, update_period, ..Default::default() }.into()
    }

    /// Numbers of the HAT/HOT questions that are due with a frame.
    fn due(questions: &mut Questions, frame: u32) -> Vec<u16> {
        let number = |question| match question {
            Packet::HatHotRequest(request) => request.hat_hot_id,
            other => panic!("{other:?}"),
        };
        questions.due(frame, &Entities::new(0.0, Terrain::ELLIPSOID)).into_iter().map(number).collect()
    }

    #[test]
    fn a_question_is_answered_once_or_with_every_nth_frame_until_it_is_asked_once() {
        let mut questions = Questions::default();
        assert!(questions.ask(heights(1, 0)) && questions.ask(heights(2, 3)) && questions.ask(heights(3, 2)));
        let said: Vec<Vec<u16>> = (1..=6).map(|frame| due(&mut questions, frame)).collect();
        assert_eq!(said, [vec![1], vec![3], vec![2], vec![3], vec![], vec![2, 3]]);
        // The same number without a period: once more, and then no more.
        questions.ask(heights(2, 0));
        assert_eq!(
            [due(&mut questions, 7), due(&mut questions, 9), due(&mut questions, 12)],
            [vec![2], vec![], vec![3]]
        );
    }

    #[test]
    fn a_question_that_hangs_on_an_entity_ends_with_it() {
        let mut entities = Entities::new(0.0, Terrain::ELLIPSOID);
        let moment = Moment { host_frame: 1, timestamp: None, extrapolate: false, now_s: 0.0 };
        let entity = |entity_state| EntityControl { entity_id: 4, entity_state, ..Default::default() };
        entities.control(&entity(1), &moment).expect("room");
        let mut questions = Questions::default();
        questions.ask(
            LineOfSightVectorRequest {
                source_point_coordinate_system: true,
                entity_id: 4,
                update_period: 1,
                ..Default::default()
            }
            .into(),
        );
        assert_eq!(questions.due(1, &entities).len(), 1);
        entities.control(&entity(2), &moment).expect("destroyed");
        assert_eq!(questions.due(2, &entities).len(), 0);
        entities.control(&entity(1), &moment).expect("another of that number");
        assert_eq!(questions.due(3, &entities).len(), 0, "it has ended");
    }

    #[test]
    fn there_is_an_end_to_questions() {
        let mut questions = Questions::default();
        for id in 0..CIGI_QUESTIONS.max(CIGI_PERIODIC_QUESTIONS) as u16 {
            assert!(questions.ask(heights(id, 0)) && questions.ask(heights(id, 1)), "{id}");
        }
        assert!(!questions.ask(heights(u16::MAX, 0)) && !questions.ask(heights(u16::MAX, 1)));
        assert!(questions.ask(heights(0, 2)), "one that is known may change");
    }
}
