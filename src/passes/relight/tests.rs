//! Fields keep their energy, stay at their place, are solved once, and what stands for a cloud's face is told with its error.

use super::emergent::emergent;
use super::store::{Found, Store};
use super::twin::{on_ground, scattered};
use super::*;
use crate::clouds::coverage::Coverage;
use crate::passes::common::Chart;
use glam::Vec3;

/// A layer around a flash: overcast stratocumulus unless changed, one chart, no map.
pub(super) fn request(thickness_m: f32, coverage: f32, extinction: f32, points: Vec<Point>) -> Request {
    let kind = CloudKind::Stratocumulus;
    let layer = Layer {
        base_m: 1000.0,
        thickness_m,
        extinction_per_m: extinction,
        inverse_edge: 1.0 / kind.appearance().edge,
        theta: Coverage::of(kind).threshold(coverage).typical,
        charts: 1,
        chart: [Chart::UNUSED; 3],
        ..Layer::zeroed()
    };
    Request { kind, layer, earth_m: 6_371_000.0, points, method: Lighting::Solve, patch: None }
}

fn one(position_m: [f32; 3]) -> Vec<Point> {
    vec![Point { position_m, share: 1.0 }]
}

/// The flash stands at the eye's ground point, the axes agree.
const HERE: Placing =
    Placing { axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], origin_m: [0.0; 3], intensity_cd: 1.0 };

fn prepared(field: &Arc<Field>, placing: &Placing) -> Prepared {
    let mut lits = Lits::zeroed();
    (lits.fields, lits.lit[0]) = (1, field.placed(placing));
    Prepared { lits, fields: vec![Some(field.clone())], provisional: false }
}

#[test]
fn what_comes_out_of_the_faces_is_what_was_sent() {
    // A source in the middle of an overcast layer of 600 m: next to nothing leaves sideways.
    let field = solve::field(&request(600.0, 1.0, 0.04, one([0.0, 0.0, 1300.0]))).expect("a cloud");
    let sum = field.below.share + field.above.share;
    // The mean phase function of the 26 directions is a little less forward than the true one, by which fluxes are found
    // (numbers of the prototypes: asymmetry 0.79 for 0.85), and the solve stops at a hundredth.
    assert!((0.85..1.1).contains(&sum), "{sum}");
    assert!(field.below.share > 0.25 && field.above.share > 0.25, "{:?} {:?}", field.below, field.above);
    assert_eq!(field.method, Method::Solve);
    assert!(field.quotients.iter().flatten().all(|v| v.is_finite()));
}

#[test]
fn a_second_tile_stays_dark_and_the_light_lies_where_the_flash_is() {
    let field = Arc::new(solve::field(&request(600.0, 1.0, 0.04, one([0.0, 0.0, 1300.0]))).expect("a cloud"));
    let at = |placing: &Placing, p: Vec3| {
        let lit = prepared(&field, placing);
        scattered(&lit.lits, &lit.fields, p, 1300.0, Vec3::Z)
    };
    let near = at(&HERE, Vec3::new(100.0, 0.0, 1300.0));
    for (east, north) in [(16_000.0, 0.0), (0.0, -16_000.0)] {
        let tile = at(&HERE, Vec3::new(east + 100.0, north, 1300.0));
        // One tile on is the same cloud; light that had wrapped would be as bright as here.
        assert!(tile < 1e-4 * near, "{tile} {near}");
    }
    // Turned and moved, the same place of the cloud has the same light.
    let moved =
        Placing { axes: [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], origin_m: [5000.0, -300.0, 0.0], ..HERE };
    for (x, y) in [(120.0, 40.0), (-700.0, 350.0)] {
        let (a, b) = (at(&HERE, Vec3::new(x, y, 1300.0)), at(&moved, Vec3::new(5000.0 - y, x - 300.0, 1300.0)));
        assert!((a / b - 1.0).abs() < 1e-3, "{a} {b}");
    }
}

#[test]
fn more_scattering_is_more_than_one_and_both_fall_to_nothing_where_no_cloud_is() {
    let solved = request(600.0, 1.0, 0.04, one([0.0, 0.0, 1300.0]));
    let single = Request { method: Lighting::Single, ..solved.clone() };
    let light = |request: &Request| {
        let field = Arc::new(solve::field(request).expect("a cloud"));
        let lit = prepared(&field, &HERE);
        scattered(&lit.lits, &lit.fields, Vec3::new(900.0, 0.0, 1300.0), 1300.0, Vec3::Z)
    };
    // 900 m through cloud of 0.04 per metre: what has been scattered once is gone.
    assert!(light(&solved) > 10.0 * light(&single));
    assert!(solve::field(&Request { layer: Layer { theta: 1.0, ..solved.layer }, ..solved.clone() }).is_none());
    let bad = Request { layer: Layer { thickness_m: f32::NAN, ..solved.layer }, ..solved };
    assert!(solve::field(&bad).is_none());
}

#[test]
fn a_field_gives_the_light_of_its_cells() {
    let request = request(600.0, 0.6, 0.04, one([37.0, -90.0, 1250.0]));
    let field = Arc::new(solve::field(&request).expect("a cloud"));
    let lit = prepared(&field, &HERE);
    let window = field.window;
    for cell in [[16, 16, 3], [20, 11, 5], [3, 28, 0]] {
        let p: [f32; 3] = std::array::from_fn(|k| window.corner_m[k] + (cell[k] as f32 + 0.5) * window.cell_m[k]);
        let stored = field.quotients[cell[0] + WIDTH * (cell[1] + WIDTH * cell[2])];
        let expected = (stored[0] + stored[3]).max(0.0) * solve::in_air(&field.points, field.cap_m2, p);
        let found = scattered(&lit.lits, &lit.fields, Vec3::from(p), p[2], Vec3::Z);
        // Rounding of f32 positions against cells of 300 m.
        assert!((found / expected - 1.0).abs() < 1e-3, "{cell:?}: {found} {expected}");
    }
}

#[test]
fn a_face_as_one_patch_lights_the_ground_as_its_columns_do() {
    let window = Window { corner_m: [-4000.0, -4000.0, 1000.0], cell_m: [250.0, 250.0, 75.0], cells: [32, 32, 8] };
    let place = |i: usize| [0, 1].map(|k| window.corner_m[k] + ([i % 32, i / 32][k] as f32 + 0.5) * 250.0);
    // A lit patch 600 m wide that falls off as light under a deck does.
    let flux: Vec<f32> = (0..1024)
        .map(|i| {
            let [x, y] = place(i);
            (-((x - 200.0).powi(2) + y * y).sqrt() / 600.0).exp()
        })
        .collect();
    let found = emergent(&window, &flux);
    assert!((found.middle_m[0] - 200.0).abs() < 20.0 && found.middle_m[1].abs() < 1.0);
    let field = Field {
        window,
        quotients: Vec::new(),
        points: Vec::new(),
        cap_m2: 1.0,
        below: found,
        above: Emergent::default(),
        method: Method::Solve,
        stand_in: false,
        summed: None,
    };
    let mut lits = Lits::zeroed();
    (lits.fields, lits.lit[0]) = (1, field.placed(&HERE));
    for (x, bound) in [(200.0, 0.1), (1200.0, 0.1), (2200.0, 0.1), (5000.0, 0.2), (30_000.0, 0.05)] {
        // Each column sends the cosine: E = sum of flux / pi cos^2 / d^2, the height being that of the face.
        let columns: f32 = (0..1024)
            .map(|i| {
                let [u, v] = place(i);
                let d2 = (u - x).powi(2) + v * v + 1e6;
                flux[i] * 62_500.0 / std::f32::consts::PI * 1e6 / (d2 * d2)
            })
            .sum();
        let patch = on_ground(&lits, Vec3::new(x, 0.0, 0.0), Vec3::Z);
        // One patch has no tails; by how much that matters is what is stated in `emergent`.
        assert!((patch / columns - 1.0).abs() < bound, "{x}: {patch} {columns}");
    }
}

#[test]
fn each_field_is_solved_once_and_nobody_waits_while_running_free() {
    let request = Arc::new(request(300.0, 1.0, 0.02, one([0.0, 0.0, 1100.0])));
    let flash = LitFlash { request: request.clone(), placing: HERE };
    let mut store = Store::default();
    assert!(Prepared::new(&mut store, &[], &[], true).fields.is_empty() && store.is_empty());
    let first = Prepared::new(&mut store, std::slice::from_ref(&flash), &[], false);
    assert!(first.provisional && first.fields == [None], "its points stand in");
    assert!(first.lits.lit[0].levels == 0 && first.lits.lit[0].points == 1);
    let waited = Prepared::new(&mut store, std::slice::from_ref(&flash), &[], true);
    let brighter = LitFlash { placing: Placing { intensity_cd: 5.0, ..HERE }, ..flash };
    let again = Prepared::new(&mut store, &[brighter], &[], false);
    let (Some(a), Some(b)) = (&waited.fields[0], &again.fields[0]) else { panic!("both have the field") };
    assert!(Arc::ptr_eq(a, b) && !again.provisional && store.len() == 1, "a stroke only weights it");
    assert_eq!(again.lits.lit[0].intensity_cd, 5.0);
    assert!(matches!(store.fields(&[request], true)[..], [Found::Ready(Some(_))]));
}

#[test]
fn a_table_takes_the_place_of_the_solve_that_stood_in_for_it_over_some_frames() {
    let window = Window { corner_m: [-600.0, -600.0, 1_000.0], cell_m: [150.0, 150.0, 75.0], cells: [8, 8, 4] };
    let solved = request(300.0, 1.0, 0.0012, one([40.0, 30.0, 1_150.0]));
    let request = Arc::new(Request { method: Lighting::Hybrid, patch: Some(window), ..solved });
    let flash = LitFlash { request: request.clone(), placing: HERE };
    let mut store = Store::default();
    let picture = |store: &mut Store| Prepared::new(store, std::slice::from_ref(&flash), &[], false);
    // The solve is made and the lights are baked beside the pictures: however long that takes, no picture waits.
    let mut pictures = Vec::new();
    while pictures.last().is_none_or(|last: &Prepared| last.provisional) {
        pictures.push(picture(&mut store));
        std::thread::sleep(std::time::Duration::from_millis(1));
        pictures.dedup_by(|b, a| a.lits == b.lits);
    }
    let bare = pictures.iter().position(|p| p.lits.lit[0].levels > 0).expect("a field");
    assert!(bare == 1, "points stand in until there is a field");
    let solve = &pictures[1];
    let stands_in = |p: &Prepared| p.fields[0].as_ref().is_some_and(|field| field.stand_in);
    assert!(stands_in(solve) && solve.lits.fields == 1);
    // Then shares of both, which are all of the light, ever more of it by the table.
    let turning = &pictures[2..pictures.len() - 1];
    assert_eq!(turning.len(), super::store::TURNING as usize - 1);
    let mut last = 0.0;
    for picture in turning {
        let [to, from] = [0, 1].map(|k| picture.lits.lit[k].intensity_cd);
        assert!(picture.lits.fields == 2 && picture.fields.len() == 2 && picture.provisional);
        assert!(to > last && from > 0.0 && (to + from - 1.0).abs() < 1e-5, "{to} {from}");
        assert!(!stands_in(picture) && picture.fields[1] == solve.fields[0]);
        last = to;
    }
    // In the end it is the picture that who waits has from the first.
    let end = pictures.last().expect("one");
    let waited = Prepared::new(&mut Store::default(), std::slice::from_ref(&flash), &[], true);
    assert!(end.lits == waited.lits && end.fields == waited.fields && !waited.provisional);
    // Where there is no room for two, the table comes at once.
    let mut full = Store::default();
    let crowd: Vec<_> = (0..FIELDS)
        .map(|i| {
            let points = one([40.0 + i as f32, 30.0, 1_150.0]);
            LitFlash { request: Arc::new(Request { points, ..(*request).clone() }), placing: HERE }
        })
        .collect();
    let mut most = 0;
    while {
        let picture = Prepared::new(&mut full, &crowd, &[], false);
        most = most.max(picture.lits.fields as usize);
        picture.provisional
    } {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    assert_eq!(most, FIELDS);
}
