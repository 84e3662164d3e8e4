//! A CIGI host that flies on, by its own clock or in step with the image generator, while delays are measured.

use crate::serve::{Stage, Stages};
use crate::wire::cigi::message::{BYTE_SWAP_MAGIC, encode_packet};
use crate::wire::cigi::packets::{EntityControl, IgControl, Packet, WeatherControl};
use crate::wire::cigi::{ByteOrder, Version, decode};
use std::net::{SocketAddr, UdpSocket};
use std::time::{Duration, Instant};

/// Frames that are not measured: until then tables and pipelines are made.
const WARM_UP_FRAMES: usize = 5;
/// Longest warm-up, and longest silence of the image generator.
const PATIENCE: Duration = Duration::from_secs(240);

/// A flight.
pub struct Flight {
    /// The host's port.
    pub socket: UdpSocket,
    /// Messages a second; in step, one for each Start of Frame.
    pub rate_hz: f64,
    /// In step.
    pub synchronous: bool,
    /// How long is measured.
    pub duration: Duration,
}

/// What was measured on.
#[derive(Clone, Copy, Debug)]
pub struct Flown {
    /// Messages sent.
    pub messages: u64,
    /// In so many seconds.
    pub seconds: f64,
}

struct Host {
    flight: Flight,
    to: SocketAddr,
    frame: u32,
    ig_frame: u32,
}

impl Flight {
    /// Flies over a deck; what the stages hold at the end is from the measured part.
    ///
    /// # Errors
    /// In words: the image generator is silent, or the system refuses the socket.
    pub fn fly(self, stages: &Stages) -> Result<Flown, String> {
        let words = |error: std::io::Error| error.to_string();
        self.socket.set_read_timeout(Some(Duration::from_secs(30))).map_err(words)?;
        let mut bytes = [0; 2_048];
        let (_, to) = self.socket.recv_from(&mut bytes).map_err(|error| format!("no Start of Frame: {error}"))?;
        let mut host = Host { flight: self, to, frame: 0, ig_frame: 0 };
        host.send(vec![deck()]).map_err(words)?;
        let (mut beat, began) = (Instant::now(), Instant::now());
        let mut drawn = 0;
        while drawn < WARM_UP_FRAMES {
            host.next(&mut beat).map_err(words)?;
            drawn = stages.newest_us(Stage::Whole).len();
            if began.elapsed() > PATIENCE {
                return Err(format!("{drawn} frames in {} s", PATIENCE.as_secs()));
            }
        }
        stages.clear();
        let (began, first) = (Instant::now(), host.frame);
        // At least one frame, however slow they are.
        while began.elapsed() < host.flight.duration || stages.newest_us(Stage::Send).is_empty() {
            host.next(&mut beat).map_err(words)?;
            if began.elapsed() > PATIENCE {
                return Err("frames have stopped".to_owned());
            }
        }
        Ok(Flown { messages: u64::from(host.frame - first), seconds: began.elapsed().as_secs_f64() })
    }
}

impl Host {
    /// Waits for the clock, or for the image generator, and says where the aircraft is.
    fn next(&mut self, beat: &mut Instant) -> std::io::Result<()> {
        if self.flight.synchronous {
            self.listen(Duration::from_secs(1))?;
        } else {
            *beat += Duration::from_secs_f64(1.0 / self.flight.rate_hz);
            // A machine that is far behind does not catch up with a burst.
            *beat = (*beat).max(Instant::now());
            while let Some(left) = beat.checked_duration_since(Instant::now()).filter(|left| !left.is_zero()) {
                self.listen(left)?;
            }
        }
        let seconds = f64::from(self.frame) / self.flight.rate_hz;
        let place = EntityControl {
            entity_state: 1,
            lat_xoff: 47.0 + 1e-3 * seconds,
            lon_yoff: 8.0,
            alt_zoff: 900.0,
            pitch: 3.0,
            yaw: (5.0 * seconds % 360.0) as f32,
            ..Default::default()
        };
        self.send(vec![place.into()])
    }

    fn send(&mut self, packets: Vec<Packet>) -> std::io::Result<()> {
        self.frame += 1;
        let [major_version, minor_version] = Version::V3.numbers();
        let control = IgControl {
            major_version,
            minor_version,
            ig_mode: 1,
            byte_swap_magic: BYTE_SWAP_MAGIC,
            host_frame_number: self.frame,
            last_ig_frame_number: self.ig_frame,
            ..Default::default()
        };
        let packets = std::iter::once(Packet::from(control)).chain(packets);
        let bytes: Result<Vec<_>, _> =
            packets.map(|packet| encode_packet(&packet, Version::V3, ByteOrder::Little)).collect();
        let bytes = bytes.map_err(std::io::Error::other)?.concat();
        self.flight.socket.send_to(&bytes, self.to).map(|_| ())
    }

    /// Takes one message of the image generator, if one comes in time.
    fn listen(&mut self, limit: Duration) -> std::io::Result<()> {
        use std::io::ErrorKind::{TimedOut, WouldBlock};
        self.flight.socket.set_read_timeout(Some(limit))?;
        let mut bytes = [0; 2_048];
        match self.flight.socket.recv(&mut bytes) {
            Ok(length) => {
                let message = decode(&bytes[..length]).map_err(std::io::Error::other)?;
                if let Some(Packet::StartOfFrame(start)) = message.packets.first() {
                    self.ig_frame = start.ig_frame_number;
                }
                Ok(())
            }
            Err(error) if matches!(error.kind(), TimedOut | WouldBlock) => Ok(()),
            Err(error) => Err(error),
        }
    }
}

/// Broken cumulus above the flight.
fn deck() -> Packet {
    WeatherControl {
        layer_id: 1,
        weather_enable: true,
        cloud_type: 7,
        coverage: 60.0,
        base_elevation: 1_300.0,
        thickness: 1_000.0,
        horizontal_wind_speed: 8.0,
        ..Default::default()
    }
    .into()
}
