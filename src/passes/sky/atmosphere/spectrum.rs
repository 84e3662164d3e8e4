//! The colours of three coefficients against those of the spectrum: light scattered once by clear air, wavelength by wavelength.

use super::{OZONE_PER_M, RAYLEIGH_PER_M, TOP_M, ozone_density};
use crate::passes::common::AIR_SCALE_M;
use glam::{DVec2, DVec3, Vec3};

const EARTH_M: f64 = 6_371_000.0;
/// Middles of the bands, nm.
const FIRST_NM: usize = 400;
const STEP_NM: usize = 20;
const BANDS: usize = 16;
/// Ozone's cross-section at 233 K in bands of 10 nm from each wavelength, 1e-25 m2 (Gorshelev et al. 2014, Serdyuchenko et al. 2014,
/// as Bruneton 2017 has them averaged).
const OZONE: [f64; BANDS] =
    [0.015, 0.055, 0.158, 0.367, 0.775, 1.48, 2.139, 3.091, 4.266, 4.398, 5.019, 3.74, 2.662, 1.852, 1.209, 0.746];
/// Molecules where ozone is densest, 1/m3: 300 Dobson units over 15 km.
const DENSEST: f64 = 300.0 * 2.687e20 / 15_000.0;

fn nm(band: usize) -> f64 {
    (FIRST_NM + band * STEP_NM) as f64
}

/// Linear sRGB of a spectrum (colour matching functions by Wyman, Sloan and Shirley 2013, equation 4; IEC 61966-2-1).
fn srgb(spectrum: impl Fn(usize) -> f64) -> DVec3 {
    let lobe = |nm: f64, middle: f64, below: f64, above: f64| {
        let off = (nm - middle) / if nm < middle { below } else { above };
        (-0.5 * off * off).exp()
    };
    let xyz: DVec3 = (0..BANDS)
        .map(|band| {
            let l = nm(band);
            let x = 1.056 * lobe(l, 599.8, 37.9, 31.0) + 0.362 * lobe(l, 442.0, 16.0, 26.7)
                - 0.065 * lobe(l, 501.1, 20.4, 26.2);
            let y = 0.821 * lobe(l, 568.8, 46.9, 40.5) + 0.286 * lobe(l, 530.9, 16.3, 31.1);
            let z = 1.217 * lobe(l, 437.0, 11.8, 36.0) + 0.681 * lobe(l, 459.0, 26.0, 13.8);
            DVec3::new(x, y, z) * spectrum(band)
        })
        .sum();
    DVec3::new(
        3.2406 * xyz.x - 1.5372 * xyz.y - 0.4986 * xyz.z,
        -0.9689 * xyz.x + 1.8758 * xyz.y + 0.0415 * xyz.z,
        0.0557 * xyz.x - 0.2040 * xyz.y + 1.0570 * xyz.z,
    )
}

/// The sun outside the air: Planck's law at 5,778 K.
fn sun(band: usize) -> f64 {
    let metres = nm(band) * 1e-9;
    (metres * 1e8).powi(-5) / ((0.014_388 / (metres * 5_778.0)).exp() - 1.0)
}

/// Pieces of a ray from the ground (scattering air, then columns of air and ozone on the light's way, m): the sun and the ray by their
/// elevations, the ray towards the sun or away from it.
fn pieces(sun_deg: f64, ray_deg: f64, towards: f64) -> Vec<[f64; 3]> {
    let ray = DVec2::from_angle(ray_deg.to_radians()) * DVec2::new(towards, 1.0);
    let light = DVec2::from_angle(sun_deg.to_radians());
    let eye = DVec2::new(0.0, EARTH_M + 1.0);
    let end_m = |from: DVec2, along: DVec2| {
        let b = from.dot(along);
        (b * b - from.length_squared() + (EARTH_M + f64::from(TOP_M)).powi(2)).sqrt() - b
    };
    let columns = |from: DVec2, along: DVec2, end: f64| {
        let ds = end / 80.0;
        let at = |k: u32| (from + along * ((f64::from(k) + 0.5) * ds)).length() - EARTH_M;
        (0..80).try_fold([0.0; 2], |[air, ozone], k| {
            let height = at(k);
            let ozone = ozone + f64::from(ozone_density(height as f32)) * ds;
            (height >= 0.0).then(|| [air + (-height / f64::from(AIR_SCALE_M)).exp() * ds, ozone])
        })
    };
    let (end, count) = (end_m(eye, ray), 60);
    let mut found = Vec::new();
    let mut before = 0.0;
    for k in 0..count {
        let until = end * (f64::from(k + 1) / f64::from(count)).powi(2);
        let (middle, ds) = (0.5 * (until + before), until - before);
        before = until;
        let at = eye + ray * middle;
        let here = (-(at.length() - EARTH_M) / f64::from(AIR_SCALE_M)).exp() * ds;
        let to_eye = columns(eye, ray, middle);
        if let (Some(from_sun), Some(to_eye)) = (columns(at, light, end_m(at, light)), to_eye) {
            found.push([here, from_sun[0] + to_eye[0], from_sun[1] + to_eye[1]]);
        }
    }
    found
}

/// Colour of a ray by the spectrum and by three coefficients, green as 1.
fn colours(sun_deg: f64, ray_deg: f64, towards: f64, rayleigh: Vec3, ozone: Vec3) -> [DVec3; 2] {
    let pieces = pieces(sun_deg, ray_deg, towards);
    let scattered = |per_air: f64, per_ozone: f64| -> f64 {
        pieces.iter().map(|[here, air, o3]| per_air * here * (-per_air * air - per_ozone * o3).exp()).sum()
    };
    // Bodhaine's and others' 1/lambda^4 with the constant that Bruneton 2017 takes.
    let of_band = |band: usize| scattered(1.240_62e-6 * (nm(band) * 1e-3).powi(-4), OZONE[band] * 1e-25 * DENSEST);
    let spectral = srgb(|band| sun(band) * of_band(band)) / srgb(sun);
    let three: DVec3 = DVec3::from_array(std::array::from_fn(|k| scattered(rayleigh[k].into(), ozone[k].into())));
    [spectral / spectral.y, three / three.y]
}

const CASES: [(f64, f64, f64); 10] = [
    (60.0, 90.0, 1.0),
    (60.0, 8.0, 1.0),
    (10.0, 90.0, 1.0),
    (4.0, 30.0, -1.0),
    (1.0, 90.0, 1.0),
    (1.0, 8.0, 1.0),
    (-3.0, 90.0, 1.0),
    (-3.0, 8.0, 1.0),
    (-5.0, 90.0, 1.0),
    (-5.0, 30.0, -1.0),
];

#[test]
fn three_coefficients_give_the_colours_of_the_spectrum_by_day_and_in_twilight() {
    for (sun_deg, ray_deg, towards) in CASES {
        let [spectral, three] = colours(sun_deg, ray_deg, towards, RAYLEIGH_PER_M, OZONE_PER_M);
        // The fit itself is within 6 % of any channel over green; bands of 20 nm and a sun by Planck's law put in as much again.
        let ratio = three / spectral;
        assert!((ratio - DVec3::ONE).abs().max_element() < 0.12, "{sun_deg} {ray_deg}: {three}, spectrum {spectral}");
    }
}

#[test]
fn the_zenith_of_a_civil_twilight_is_blue_and_three_wavelengths_make_it_lilac() {
    // Lee, Meyer and Hoeppe 2011 measured zeniths of clear civil twilights: blue, since red stays below green.
    let [spectral, three] = colours(-5.0, 90.0, 1.0, RAYLEIGH_PER_M, OZONE_PER_M);
    assert!(spectral.x < 0.85 && three.x < 0.85 && three.z > 1.6, "{spectral} {three}");
    // The tester: by 680, 550 and 440 nm red is nearly twice green.
    let usual = [Vec3::new(5.802e-6, 13.558e-6, 33.1e-6), Vec3::new(0.650e-6, 1.881e-6, 0.085e-6)];
    let [_, lilac] = colours(-5.0, 90.0, 1.0, usual[0], usual[1]);
    assert!(lilac.x > 1.5, "{lilac}");
}
