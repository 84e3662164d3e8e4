//! Rays and spheres about the Earth's centre in f64: where a ray is between two heights.

use glam::DVec3;

/// Height over a sphere of radius `earth_m` of a point given over the tangent plane at the origin.
pub fn height_m(earth_m: f64, p: DVec3) -> f64 {
    // |p + (0, 0, r)| - r without cancellation.
    let excess = p.length_squared() + 2.0 * p.z * earth_m;
    excess / ((earth_m * earth_m + excess).max(0.0).sqrt() + earth_m)
}

/// Ranges at which a ray meets the sphere at a height, before and behind its origin; `None` where it passes by.
pub fn crossings(earth_m: f64, p: DVec3, d: DVec3, height_m: f64) -> Option<(f64, f64)> {
    let half = p.dot(d) + earth_m * d.z;
    let apart = p.length_squared() + 2.0 * p.z * earth_m - height_m * (2.0 * earth_m + height_m);
    let root = (half * half - apart).max(0.0).sqrt();
    if half * half <= apart {
        return None;
    }
    // The root of the larger size without cancellation, the other by their product.
    let far = if half > 0.0 { -half - root } else { -half + root };
    let near = if far == 0.0 { 0.0 } else { apart / far };
    Some((near.min(far), near.max(far)))
}

/// The stretches of a ray between two heights, in order, from range 0 on: two at most, unused ones empty.
pub fn stretches(earth_m: f64, p: DVec3, d: DVec3, [base_m, top_m]: [f64; 2]) -> [(f64, f64); 2] {
    const EMPTY: (f64, f64) = (0.0, 0.0);
    let Some((enters, leaves)) = crossings(earth_m, p, d, top_m) else { return [EMPTY; 2] };
    let pieces = match crossings(earth_m, p, d, base_m) {
        Some((falls, rises)) => [(enters, falls), (rises, leaves)],
        None => [(enters, leaves), EMPTY],
    };
    pieces.map(|(begin, end)| if begin.max(0.0) < end { (begin.max(0.0), end) } else { EMPTY })
}

#[cfg(test)]
mod tests {
    use super::*;

    const EARTH_M: f64 = 6_371_000.0;

    #[test]
    fn stretches_are_where_the_height_is_between() {
        let edges = [1_000.0, 2_200.0];
        for (eye_m, z) in
            [(100.0, 0.3), (100.0, 0.001), (5e3, -0.2), (5e3, -0.02), (1_500.0, 0.0), (1_500.0, -0.05), (3e3, 0.1)]
        {
            let (p, d) = (DVec3::new(0.0, 0.0, eye_m), DVec3::new(0.0, (1.0f64 - z * z).sqrt(), z));
            let pieces = stretches(EARTH_M, p, d, edges);
            for i in 0..4_000 {
                let t = 0.5 + 100.0 * f64::from(i);
                let height = height_m(EARTH_M, p + d * t);
                let inside = pieces.iter().any(|(begin, end)| (begin..=end).contains(&&t));
                // Roots of differences of 1e13 m2 in f64: heights are right to a millimetre.
                let at_edge = edges.iter().any(|edge: &f64| (height - edge).abs() < 1e-2);
                assert!(at_edge || inside == (edges[0]..edges[1]).contains(&height), "{eye_m} {z} {t}: {height}");
            }
        }
    }

    #[test]
    fn straight_up_and_down_are_the_heights_themselves() {
        let p = DVec3::new(0.0, 0.0, 800.0);
        let (_, ahead) = crossings(EARTH_M, p, DVec3::Z, 1_000.0).expect("above");
        let (down, _) = crossings(EARTH_M, p, DVec3::NEG_Z, 0.0).expect("below");
        // Products of 6e6 m in f64.
        assert!((ahead - 200.0).abs() < 1e-6 && (down - 800.0).abs() < 1e-6, "{ahead} {down}");
        assert_eq!(crossings(EARTH_M, p, DVec3::X, 0.0), None);
    }
}
