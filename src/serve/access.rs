//! Who may come in: the Origin and Host of a browser, and the access token.

use axum::http::{HeaderMap, StatusCode, header};
use std::net::IpAddr;
use subtle::ConstantTimeEq;

/// The rules of this server.
pub(super) struct Access {
    token: Option<String>,
    origins: Vec<String>,
    loopback: bool,
}

/// What a request has shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Trust {
    /// The token, or none is needed.
    Trusted,
    /// No token: good for a WebSocket whose `hello` will carry it, and for nothing else.
    Stranger,
}

/// Why a request was turned away.
pub(super) type Denied = (StatusCode, &'static str);

impl Access {
    /// `origins`: pages from elsewhere that may connect, as `https://example.org:8443`. `bound`: where the server listens.
    pub(super) fn new(token: Option<String>, origins: Vec<String>, bound: IpAddr) -> Self {
        Self { token, origins, loopback: bound.is_loopback() }
    }

    /// Compares in constant time: how long it takes says nothing about how much was right.
    pub(super) fn token_fits(&self, given: &str) -> bool {
        self.token.as_ref().is_none_or(|token| bool::from(token.as_bytes().ct_eq(given.as_bytes())))
    }

    /// Judges the headers of a request and the `token` of its query.
    pub(super) fn judge(&self, headers: &HeaderMap, query_token: Option<&str>) -> Result<Trust, Denied> {
        self.check_host(headers)?;
        self.check_origin(headers)?;
        let bearer = match headers.get(header::AUTHORIZATION) {
            None => None,
            Some(value) => {
                let bearer = value.to_str().ok().and_then(|text| text.strip_prefix("Bearer "));
                Some(bearer.ok_or((StatusCode::UNAUTHORIZED, "Authorization must be: Bearer TOKEN"))?)
            }
        };
        match (&self.token, bearer.or(query_token)) {
            (None, _) => Ok(Trust::Trusted),
            (Some(_), None) => Ok(Trust::Stranger),
            (Some(_), Some(given)) if self.token_fits(given) => Ok(Trust::Trusted),
            (Some(_), Some(_)) => Err((StatusCode::UNAUTHORIZED, "this is not the server's token")),
        }
    }

    /// A browser that was tricked into resolving a foreign name to this machine still sends that name (DNS rebinding).
    fn check_host(&self, headers: &HeaderMap) -> Result<(), Denied> {
        if !self.loopback {
            return Ok(());
        }
        let Some(host) = headers.get(header::HOST) else { return Ok(()) };
        let host = host.to_str().map_err(|_| (StatusCode::BAD_REQUEST, "the Host header is no text"))?;
        let name = without_port(host);
        let local = name.eq_ignore_ascii_case("localhost")
            || name.trim_matches(['[', ']']).parse::<IpAddr>().is_ok_and(|address| address.is_loopback());
        if local || self.origins.iter().any(|origin| authority(origin) == Some(host)) {
            return Ok(());
        }
        Err((StatusCode::FORBIDDEN, "this server listens on the local machine only, and not under that name"))
    }

    /// Programs send no Origin. A browser does, and must come from this server's own page or from an allowed one.
    fn check_origin(&self, headers: &HeaderMap) -> Result<(), Denied> {
        let Some(origin) = headers.get(header::ORIGIN) else { return Ok(()) };
        let denied = (StatusCode::FORBIDDEN, "pages from this origin may not connect: see allowed_origins");
        let origin = origin.to_str().map_err(|_| denied)?;
        let host = headers.get(header::HOST).and_then(|host| host.to_str().ok());
        let same = host.is_some() && authority(origin) == host;
        if same || self.origins.iter().any(|allowed| allowed == origin) { Ok(()) } else { Err(denied) }
    }
}

/// `host:port` of an origin.
fn authority(origin: &str) -> Option<&str> {
    origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://"))
}

fn without_port(host: &str) -> &str {
    match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|byte| byte.is_ascii_digit()) => name,
        _ => host,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::Ipv4Addr;

    fn headers(pairs: &[(header::HeaderName, &str)]) -> HeaderMap {
        pairs.iter().map(|(name, value)| (name.clone(), value.parse().unwrap())).collect()
    }

    fn judge(access: &Access, pairs: &[(header::HeaderName, &str)], query: Option<&str>) -> Result<Trust, StatusCode> {
        access.judge(&headers(pairs), query).map_err(|(status, _)| status)
    }

    #[test]
    fn pages_from_elsewhere_are_turned_away() {
        let local = Access::new(None, vec!["https://panel.example".into()], Ipv4Addr::LOCALHOST.into());
        let from = |origin| judge(&local, &[(header::HOST, "127.0.0.1:8765"), (header::ORIGIN, origin)], None);
        assert_eq!(from("http://127.0.0.1:8765"), Ok(Trust::Trusted));
        assert_eq!(from("https://panel.example"), Ok(Trust::Trusted));
        assert_eq!(from("http://evil.example"), Err(StatusCode::FORBIDDEN));
        assert_eq!(from("http://127.0.0.1:9999"), Err(StatusCode::FORBIDDEN));
        assert_eq!(from("null"), Err(StatusCode::FORBIDDEN));
        assert_eq!(judge(&local, &[(header::HOST, "127.0.0.1:8765")], None), Ok(Trust::Trusted), "a program");
    }

    #[test]
    fn a_foreign_name_for_this_machine_is_turned_away() {
        let local = Access::new(None, Vec::new(), Ipv4Addr::LOCALHOST.into());
        let rebound = [(header::HOST, "evil.example:8765"), (header::ORIGIN, "http://evil.example:8765")];
        assert_eq!(judge(&local, &rebound, None), Err(StatusCode::FORBIDDEN));
        for host in ["localhost:8765", "LOCALHOST", "127.0.0.1", "127.9.9.9:1", "[::1]:8765"] {
            assert_eq!(judge(&local, &[(header::HOST, host)], None), Ok(Trust::Trusted), "{host}");
        }
        let open = Access::new(None, Vec::new(), Ipv4Addr::UNSPECIFIED.into());
        assert_eq!(judge(&open, &[(header::HOST, "deck.example:8765")], None), Ok(Trust::Trusted));
    }

    #[test]
    fn the_token_comes_by_header_or_query_and_must_fit() {
        let access = Access::new(Some("correct-horse".into()), Vec::new(), Ipv4Addr::UNSPECIFIED.into());
        assert_eq!(judge(&access, &[], None), Ok(Trust::Stranger));
        assert_eq!(judge(&access, &[], Some("correct-horse")), Ok(Trust::Trusted));
        assert_eq!(judge(&access, &[], Some("correct-hors")), Err(StatusCode::UNAUTHORIZED));
        assert_eq!(judge(&access, &[(header::AUTHORIZATION, "Bearer correct-horse")], None), Ok(Trust::Trusted));
        assert_eq!(
            judge(&access, &[(header::AUTHORIZATION, "Bearer wrong")], Some("correct-horse")),
            Err(StatusCode::UNAUTHORIZED)
        );
        assert_eq!(judge(&access, &[(header::AUTHORIZATION, "Basic abc")], None), Err(StatusCode::UNAUTHORIZED));
    }
}
