//! Answers on their way out: as many as fit one datagram behind its Start of Frame, the rest with the next.

use crate::wire::cigi::message::encode_packet;
use crate::wire::cigi::packets::{Packet, StartOfFrame};
use crate::wire::cigi::{ByteOrder, Version};
use crate::wire::limits::{CIGI_ANSWERS_WAITING, CIGI_DATAGRAM_BYTES};
use std::collections::VecDeque;

/// Answers that wait.
#[derive(Default)]
pub struct Outbox {
    waiting: VecDeque<Packet>,
}

impl Outbox {
    /// Puts answers behind those that wait. Returns how many of the oldest were dropped for want of room.
    pub fn push(&mut self, answers: impl IntoIterator<Item = Packet>) -> usize {
        self.waiting.extend(answers);
        let dropped = self.waiting.len().saturating_sub(CIGI_ANSWERS_WAITING);
        self.waiting.drain(..dropped);
        dropped
    }

    /// Whether they will not all fit the next datagram.
    pub fn overfull(&self, version: Version, order: ByteOrder) -> bool {
        let mut bytes = encode_packet(&StartOfFrame::default().into(), version, order).map_or(0, |sof| sof.len());
        self.waiting.iter().any(|packet| {
            bytes += encode_packet(packet, version, order).map_or(0, |packet| packet.len());
            bytes > CIGI_DATAGRAM_BYTES
        })
    }

    /// The next datagram, and how many answers are in it. A packet that cannot be encoded is left out.
    pub fn datagram(&mut self, opening: StartOfFrame, version: Version, order: ByteOrder) -> (Vec<u8>, usize) {
        let mut bytes = encode_packet(&opening.into(), version, order).unwrap_or_default();
        let mut count = 0;
        while let Some(packet) = self.waiting.front() {
            let encoded = encode_packet(packet, version, order).unwrap_or_default();
            if bytes.len() + encoded.len() > CIGI_DATAGRAM_BYTES {
                break;
            }
            bytes.extend(encoded);
            count += 1;
            self.waiting.pop_front();
        }
        (bytes, count)
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.waiting.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::cigi::decode;
    use crate::wire::cigi::packets::HatHotResponse;

    #[test]
    fn what_does_not_fit_goes_out_with_the_next_frame() {
        for version in Version::ALL {
            let order = ByteOrder::Big;
            let [major_version, minor_version] = version.numbers();
            let sof = || StartOfFrame { major_version, minor_version, byte_swap_magic: 0x8000, ..Default::default() };
            let mut outbox = Outbox::default();
            // 16 bytes each: (1472 - 24) / 16 = 90 fit.
            let answers = (0..200).map(|hat_hot_id| HatHotResponse { hat_hot_id, ..Default::default() }.into());
            assert_eq!(outbox.push(answers), 0);
            let mut ids = Vec::new();
            for expected in [90, 90, 20, 0] {
                assert_eq!(outbox.overfull(version, order), ids.len() < 110);
                let (bytes, count) = outbox.datagram(sof(), version, order);
                assert!(count == expected && bytes.len() <= CIGI_DATAGRAM_BYTES);
                let message = decode(&bytes).expect("our own message");
                ids.extend(message.packets.iter().filter_map(|packet| match packet {
                    Packet::HatHotResponse(answer) => Some(answer.hat_hot_id),
                    _ => None,
                }));
            }
            assert_eq!(ids, (0..200).collect::<Vec<u16>>());
        }
    }

    #[test]
    fn what_nobody_fetches_is_bounded() {
        let mut outbox = Outbox::default();
        let many = (0..CIGI_ANSWERS_WAITING + 5).map(|_| HatHotResponse::default().into());
        assert_eq!(outbox.push(many), 5);
    }
}
