//! The handshake: modes, frame counters, time stamps and the database number, as a value without sockets or clocks.

use crate::wire::cigi::Version;
use crate::wire::cigi::message::BYTE_SWAP_MAGIC;
use crate::wire::cigi::packets::{IgControl, StartOfFrame};

/// Length of a tick of a time stamp.
const TICK_US: u64 = 10;
/// The one database that there is: the globe.
const GLOBE: i8 = 1;
/// `database_number` of one that does not exist.
const NO_SUCH_DATABASE: i8 = i8::MIN;

/// What the image generator does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Everything is at its defaults; only the mode of IG Control counts.
    #[default]
    Standby,
    /// Normal work.
    Operate,
    /// As `Operate`; what is refused is also said in words.
    Debug,
}

impl Mode {
    /// Its number on the wire.
    pub const fn number(self) -> u8 {
        match self {
            Self::Standby => 0,
            Self::Operate => 1,
            Self::Debug => 2,
        }
    }
}

/// What an IG Control means.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Heard {
    /// Everything returns to its defaults.
    pub reset: bool,
    /// The other packets of the message count.
    pub counts: bool,
    /// Messages of the host that were lost before this one.
    pub lost: u32,
    /// A message that is older than the newest, or the newest again.
    pub late: bool,
    /// Our frames since the Start of Frame that the host had seen.
    pub behind: u32,
    /// A mode that a host cannot ask for.
    pub bad_mode: bool,
}

/// One host's handshake.
#[derive(Clone, Debug)]
pub struct Link {
    host_chooses_database: bool,
    mode: Mode,
    database: i8,
    frame: u32,
    host_frame: Option<u32>,
}

impl Link {
    /// Before the first message. `host_chooses_database`: else the database is ours and its number always 0.
    pub fn new(host_chooses_database: bool) -> Self {
        Self { host_chooses_database, mode: Mode::Standby, database: 0, frame: 0, host_frame: None }
    }

    /// The mode now.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// Number of the newest Start of Frame.
    pub fn frame(&self) -> u32 {
        self.frame
    }

    /// Number of the host's newest message.
    pub fn host_frame(&self) -> u32 {
        self.host_frame.unwrap_or(0)
    }

    /// Forgets the host.
    pub fn part(&mut self) {
        *self = Self { frame: self.frame, ..Self::new(self.host_chooses_database) };
    }

    /// Takes the IG Control of a message.
    pub fn hear(&mut self, control: &IgControl) -> Heard {
        let mut heard = Heard::default();
        if let Some(last) = self.host_frame {
            let step = control.host_frame_number.wrapping_sub(last);
            // More than half of all numbers ahead is behind; far behind is a host that has begun anew.
            match step {
                1 => {}
                0 => heard.late = true,
                2..=0x7fff_ffff => heard.lost = step - 1,
                _ => heard.late = last.wrapping_sub(control.host_frame_number) < 1_000,
            }
        }
        if !heard.late {
            self.host_frame = Some(control.host_frame_number);
        }
        heard.behind = self.frame.wrapping_sub(control.last_ig_frame_number);
        let asked = match control.ig_mode {
            0 => Mode::Standby,
            1 => Mode::Operate,
            2 => Mode::Debug,
            _ => {
                heard.bad_mode = true;
                self.mode
            }
        };
        heard.reset = asked == Mode::Standby && self.mode != Mode::Standby;
        self.mode = asked;
        if self.mode != Mode::Standby {
            self.choose_database(control.database_number);
        } else {
            self.database = 0;
        }
        heard.counts = self.mode != Mode::Standby;
        heard
    }

    /// The next Start of Frame, `now_us` microseconds after the server began.
    pub fn start_of_frame(&mut self, version: Version, now_us: u64, overframing: bool, more: bool) -> StartOfFrame {
        self.frame = self.frame.wrapping_add(1);
        let [major_version, minor_version] = version.numbers();
        StartOfFrame {
            major_version,
            minor_version,
            database_number: self.database,
            ig_status_code: 0,
            ig_mode: self.mode.number(),
            timestamp_valid: true,
            earth_reference_model: false,
            byte_swap_magic: BYTE_SWAP_MAGIC,
            ig_frame_number: self.frame,
            // Ticks wrap around after 12 hours, which is what cutting off the upper bits does.
            timestamp: (now_us / TICK_US) as u32,
            last_host_frame_number: self.host_frame(),
            overframing,
            paging: false,
            excessive_variable_length_data: more,
        }
    }

    /// Number N: loading, until the host acknowledges with 0; then loaded. There is nothing to load, so that takes no time.
    fn choose_database(&mut self, asked: i8) {
        if !self.host_chooses_database {
            return;
        }
        self.database = match (asked, self.database) {
            (0, loading @ -127..=-1) => -loading,
            (0, same) => same,
            // The same number again while it loads, or after it was loaded: it is not loaded twice for nothing.
            (GLOBE, GLOBE) => GLOBE,
            (GLOBE, _) => -GLOBE,
            _ => NO_SUCH_DATABASE,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn control(host_frame_number: u32, ig_mode: u8, database_number: i8) -> IgControl {
        IgControl { host_frame_number, ig_mode, database_number, ..IgControl::default() }
    }

    #[test]
    fn modes_follow_the_host_and_standby_resets_once() {
        let mut link = Link::new(false);
        assert_eq!((link.hear(&control(1, 0, 0)).reset, link.mode()), (false, Mode::Standby), "nothing to reset yet");
        assert!(link.hear(&control(2, 1, 0)).counts);
        assert_eq!(link.hear(&control(3, 2, 0)), Heard { counts: true, ..link_behind(&link) });
        assert_eq!(link.mode(), Mode::Debug);
        let heard = link.hear(&control(4, 3, 0));
        assert!(heard.bad_mode && link.mode() == Mode::Debug, "offline maintenance is not the host's to ask for");
        let heard = link.hear(&control(5, 0, 0));
        assert!(heard.reset && !heard.counts);
        assert!(!link.hear(&control(6, 0, 0)).reset);
        assert_eq!(link.start_of_frame(Version::V3, 0, false, false).ig_mode, 0);
    }

    fn link_behind(link: &Link) -> Heard {
        Heard { behind: link.frame(), ..Heard::default() }
    }

    #[test]
    fn frame_numbers_count_wrap_and_tell_what_was_lost() {
        let mut link = Link::new(false);
        for (frame, lost, late) in [
            (u32::MAX - 1, 0, false),
            (u32::MAX, 0, false),
            (0, 0, false),
            (4, 3, false),
            (4, 0, true),
            (3, 0, true),
            (5, 0, false),
            // Begun anew, far away: neither late nor lost.
            (0x9000_0000, 0, false),
        ] {
            let heard = link.hear(&control(frame, 1, 0));
            assert_eq!((heard.lost, heard.late), (lost, late), "frame {frame}");
            assert!(heard.counts, "a late message counts: packets are state, in the order in which they come");
        }
        link.frame = u32::MAX;
        assert_eq!(link.start_of_frame(Version::V4, 0, false, false).ig_frame_number, 0);
        let control = IgControl { last_ig_frame_number: u32::MAX - 2, ..control(9, 1, 0) };
        assert_eq!(link.hear(&control).behind, 3);
    }

    #[test]
    fn time_stamps_are_ten_microseconds_and_wrap_around() {
        let mut link = Link::new(false);
        let mut at = |us| link.start_of_frame(Version::V3, us, false, false).timestamp;
        assert_eq!((at(0), at(19), at(1_000_000)), (0, 1, 100_000));
        // 2^32 ticks are 11 h 55 min 49.67296 s.
        let whole_us = (11 * 3_600 + 55 * 60 + 49) * 1_000_000 + 672_960;
        assert_eq!((at(whole_us - 10), at(whole_us), at(whole_us + 10)), (u32::MAX, 0, 1));
    }

    #[test]
    fn the_database_is_ours_or_goes_through_loading() {
        let mut ours = Link::new(false);
        ours.hear(&control(1, 1, 5));
        assert_eq!(ours.start_of_frame(Version::V3, 0, false, false).database_number, 0);
        let mut link = Link::new(true);
        let mut say = |mode, number| {
            link.hear(&control(1, mode, number));
            link.start_of_frame(Version::V3, 0, false, false).database_number
        };
        assert_eq!(say(0, 1), 0, "ignored in standby");
        assert_eq!([say(1, 0), say(1, 1), say(1, 1), say(1, 0), say(1, 0), say(1, 1)], [0, -1, -1, 1, 1, 1]);
        assert_eq!([say(1, 7), say(1, 0), say(1, -3), say(1, 1), say(1, 0)], [-128, -128, -128, -1, 1]);
        assert_eq!(say(0, 0), 0, "back at its default");
    }

    #[test]
    fn a_parted_host_leaves_nothing_but_our_own_count() {
        let mut link = Link::new(true);
        link.hear(&control(77, 1, 1));
        let before = link.start_of_frame(Version::V3, 0, true, true).ig_frame_number;
        link.part();
        let next = link.start_of_frame(Version::V3, 0, false, false);
        assert_eq!((next.ig_frame_number, next.last_host_frame_number, next.ig_mode), (before + 1, 0, 0));
    }
}
