//! The CIGI port in the settings: flat fields of the file, checked together, become one value.

use super::SettingsFile;
use crate::wire::cigi::ByteOrder;
use crate::world::event::Refused;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::net::{IpAddr, SocketAddr};

/// What the CIGI port is told.
#[derive(Clone, Debug, PartialEq)]
pub struct CigiSettings {
    /// Address and port to listen on by UDP.
    pub listen: SocketAddr,
    /// Where the host is; `None`: learned from the first valid datagram.
    pub host: Option<SocketAddr>,
    /// Port of a learned host that answers go to; `None`: the one that it sends from.
    pub reply_port: Option<u16>,
    /// Addresses that may be host; empty: any.
    pub allow: Vec<IpAddr>,
    /// Group to join, beside the address listened on.
    pub multicast: Option<IpAddr>,
    /// Frames wait for the host's message, and each is a step of the world.
    pub synchronous: bool,
    /// Byte order of what is sent.
    pub byte_order: ByteOrder,
    /// Start of Frame messages a second.
    pub rate_hz: f64,
    /// Seconds of silence after which the host is taken to be gone.
    pub silence_s: f64,
    /// Whether the host chooses the database; else it is ours, number 0.
    pub host_chooses_database: bool,
    /// Height of mean sea level above the ellipsoid.
    pub sea_level_m: f64,
    /// Seed of storms.
    pub seed: u64,
    /// Width and height of the host's pictures.
    pub size_px: [u32; 2],
}

/// Byte order of what is sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ByteOrderChoice {
    /// Least significant byte first.
    #[default]
    Little,
    /// Most significant byte first.
    Big,
}

/// The CIGI settings of a file; `None`: there is no CIGI port.
pub(super) fn from_file(file: &SettingsFile, complain: &mut dyn FnMut(Refused)) -> Option<CigiSettings> {
    let socket = |text: &str| text.parse::<SocketAddr>();
    let address = |text: &str| text.parse::<IpAddr>();
    let mut wrong = |field: String, value: &str, limit: &str| {
        complain(Refused::new(field, value, limit, "not an address"));
    };
    let listen = file.cigi_listen.as_deref().map(|text| socket(text).map_err(|_| text));
    let host = file.cigi_host.as_deref().map(|text| socket(text).map_err(|_| text));
    let multicast =
        file.cigi_multicast.as_deref().map(|text| address(text).ok().filter(IpAddr::is_multicast).ok_or(text));
    let allow: Vec<_> = file.cigi_allow.iter().map(|text| address(text).map_err(|_| text)).collect();
    if let Some(Err(text)) = listen {
        wrong("cigi_listen".into(), text, "as 0.0.0.0:8004");
    }
    if let Some(Err(text)) = host {
        wrong("cigi_host".into(), text, "as 192.168.1.20:8005");
    }
    if let Some(Err(text)) = multicast {
        wrong("cigi_multicast".into(), text, "a multicast address as 239.1.2.3");
    }
    for (index, text) in allow.iter().enumerate().filter_map(|(index, one)| Some((index, one.as_ref().err()?))) {
        wrong(format!("cigi_allow[{index}]"), text, "as 192.168.1.20");
    }
    let listen = listen?.ok()?;
    if !listen.ip().is_loopback() && file.cigi_host.is_none() && file.cigi_allow.is_empty() {
        let limit = "the addresses that may be host, or cigi_host";
        let why = "beyond this machine whoever speaks first would steer the world";
        complain(Refused::new("cigi_allow", "not given", limit, why));
    }
    if multicast.is_some() && listen.ip().is_loopback() {
        let why = "what is sent to a group does not come to an address of this machine alone";
        complain(Refused::new("cigi_listen", listen, "as 0.0.0.0:8004 where there is a group", why));
    }
    Some(CigiSettings {
        listen,
        host: host.and_then(Result::ok),
        reply_port: file.cigi_reply_port,
        allow: allow.into_iter().filter_map(Result::ok).collect(),
        multicast: multicast.and_then(Result::ok),
        synchronous: file.cigi_synchronous,
        byte_order: match file.cigi_byte_order {
            ByteOrderChoice::Little => ByteOrder::Little,
            ByteOrderChoice::Big => ByteOrder::Big,
        },
        rate_hz: file.cigi_rate_hz,
        silence_s: file.cigi_silence_s,
        host_chooses_database: file.cigi_host_chooses_database,
        sea_level_m: file.cigi_sea_level_m,
        seed: file.cigi_seed.into(),
        size_px: file.cigi_size_px,
    })
}

#[cfg(test)]
mod tests {
    use super::super::Settings;
    use super::*;

    #[test]
    fn there_is_no_port_unless_asked_for_and_the_example_has_the_usual_ones() {
        assert_eq!(Settings::default().cigi, None);
        let example = Settings::parse(include_str!("../../config/cigi.json")).expect("the example");
        let cigi = example.cigi.expect("a port");
        assert_eq!((cigi.listen.port(), cigi.reply_port), (8004, Some(8005)));
        assert_eq!((cigi.byte_order, cigi.synchronous, cigi.host), (ByteOrder::Little, false, None));
    }

    #[test]
    fn addresses_that_are_none_are_told_each() {
        let text =
            r#"{"cigi_listen": "x", "cigi_host": "1.2.3.4", "cigi_multicast": "10.0.0.1", "cigi_allow": ["::1", "y"]}"#;
        let complaints = Settings::parse(text).expect_err("four mistakes");
        let paths: Vec<&str> = complaints.iter().map(|complaint| complaint.path.as_str()).collect();
        assert_eq!(paths, ["cigi_listen", "cigi_host", "cigi_multicast", "cigi_allow[1]"]);
    }

    #[test]
    fn beyond_this_machine_the_settings_say_who_may_be_host() {
        let complaints = |rest: &str| {
            let parsed = Settings::parse(&format!(r#"{{"cigi_listen": {rest}}}"#));
            parsed.err().unwrap_or_default().into_iter().map(|complaint| complaint.path).collect::<Vec<_>>()
        };
        for open in [r#""0.0.0.0:8004""#, r#""192.168.1.2:8004""#, r#""[::]:8004""#] {
            assert_eq!(complaints(open), ["cigi_allow"], "{open}");
            for named in [r#""cigi_allow": ["192.168.1.20"]"#, r#""cigi_host": "192.168.1.20:8005""#] {
                assert_eq!(complaints(&format!("{open}, {named}")), [""; 0], "{open} {named}");
            }
        }
        assert_eq!(complaints(r#""127.0.0.1:8004""#), [""; 0]);
        assert_eq!(complaints(r#""127.0.0.1:8004", "cigi_multicast": "239.1.2.3""#), ["cigi_listen"]);
    }

    #[test]
    fn every_field_of_the_port_reaches_it() {
        let other = [
            r#""cigi_host": "192.168.1.2:9""#,
            r#""cigi_reply_port": 8005"#,
            r#""cigi_allow": ["192.168.1.2"]"#,
            r#""cigi_multicast": "239.1.2.3""#,
            r#""cigi_synchronous": true"#,
            r#""cigi_byte_order": "big""#,
            r#""cigi_rate_hz": 30"#,
            r#""cigi_silence_s": 1"#,
            r#""cigi_host_chooses_database": true"#,
            r#""cigi_sea_level_m": 48.5"#,
            r#""cigi_seed": 7"#,
            r#""cigi_size_px": [1920, 1080]"#,
        ];
        let parse = |more: &str| {
            let allow = if more.contains("cigi_allow") { "" } else { r#", "cigi_allow": ["192.168.1.1"]"# };
            Settings::parse(&format!(r#"{{"cigi_listen": "0.0.0.0:0"{allow}{more}}}"#)).expect(more).cigi
        };
        let usual = parse("");
        for more in other {
            assert_ne!(parse(&format!(", {more}")), usual, "{more}");
        }
    }
}
