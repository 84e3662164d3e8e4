//! Where the eye is: the one place where positions on the globe (f64) become positions relative to the eye (f32).

use crate::geo::Geodetic;
use crate::geo::charts::{BLEND, ChartView, charts_near};
use crate::geo::frames::{Curvature, ENU_NED, enu, ned_from_body};
use crate::geo::terrain::Terrain;
use crate::geo::wgs84::{MEAN_RADIUS_M, from_ecef, to_ecef};
use crate::passes::common::{CHARTS, Chart};
use crate::world::snapshot::{OwnshipState, ViewState};
use glam::{DMat3, DQuat, DVec2, DVec3, Vec3};

/// Nearer than this to the ground the eye is drawn as if it were here, so that it is never in the ground.
pub const LOWEST_EYE_M: f64 = 1.5;

/// The eye's place and the axes of the picture.
pub struct Eye {
    /// Columns east, north, up in ECEF.
    pub enu: DMat3,
    /// The ground point below, ECEF.
    pub ground_ecef_m: DVec3,
    /// Unit vector from the Earth's centre (of the sphere that stands for the Earth) through the eye.
    pub zenith: DVec3,
    /// Radius of the sphere that stands for the Earth here.
    pub earth_m: f64,
    /// Height over that sphere.
    pub height_m: f64,
    /// The eye's place.
    pub position: Geodetic,
    /// How far below the lowest height the eye would be, and has been lifted.
    pub lifted_m: f64,
    /// Forward, right and down axes of the body that carries it in east, north, up.
    pub body: [Vec3; 3],
    /// Right, up and forward axes of the picture in east, north, up.
    pub axes: [Vec3; 3],
}

impl Eye {
    /// The eye of a view over some ground.
    pub fn new(ownship: &OwnshipState, view: &ViewState, terrain: &Terrain) -> Self {
        let ownship = view.carrier.as_ref().unwrap_or(ownship);
        let body = ENU_NED * ned_from_body(&ownship.attitude);
        let offset = enu(&ownship.position) * (body * DVec3::from(view.offset_m));
        let place = from_ecef(to_ecef(&ownship.position) + offset);
        let ground_m = terrain.height_m(&place);
        let position = Geodetic { altitude_m: place.altitude_m.max(ground_m.max(0.0) + LOWEST_EYE_M), ..place };
        let axes_enu = enu(&position);
        // The view's axes against the body, in the eye's own east, north, up.
        let carried = axes_enu.transpose() * enu(&ownship.position) * body;
        let turned = carried * ned_from_body(&view.attitude);
        let column = |axis: DVec3| (turned * axis).as_vec3();
        Self {
            enu: axes_enu,
            ground_ecef_m: to_ecef(&Geodetic { altitude_m: 0.0, ..position }),
            zenith: axes_enu.z_axis,
            earth_m: Curvature::at(position.latitude_rad).mean_m(),
            height_m: position.altitude_m,
            lifted_m: position.altitude_m - place.altitude_m,
            position,
            body: [carried.x_axis, carried.y_axis, carried.z_axis].map(|axis| axis.as_vec3()),
            axes: [column(DVec3::Y), column(DVec3::NEG_Z), column(DVec3::X)],
        }
    }

    /// A direction in ECEF as east, north, up.
    pub fn direction(&self, ecef: DVec3) -> Vec3 {
        (self.enu.transpose() * ecef).as_vec3()
    }

    /// A place as east, north and height over the tangent plane at the eye's ground point.
    pub fn place(&self, place: &Geodetic) -> Vec3 {
        self.offset(place).as_vec3()
    }

    /// A place as [`Eye::place`] gives it, in f64.
    pub fn offset(&self, place: &Geodetic) -> DVec3 {
        self.enu.transpose() * (to_ecef(place) - self.ground_ecef_m)
    }

    /// The chart whose centre is nearest, fixed to the ground.
    pub fn nearest_chart(&self) -> ChartView {
        charts_near(self.zenith, self.enu.x_axis, self.enu.y_axis, DQuat::IDENTITY, 1.0)[0]
    }

    /// The charts in sight of a pattern that has drifted, with a volume tile and a map of given periods.
    pub fn charts(&self, drift: DQuat, extent_m: f64, tile_m: f64) -> (Vec<ChartView>, [Chart; CHARTS]) {
        let near = charts_near(self.zenith, self.enu.x_axis, self.enu.y_axis, drift, extent_m);
        let mut charts = [Chart::UNUSED; CHARTS];
        for (chart, view) in charts.iter_mut().zip(&near) {
            *chart = narrow(view, tile_m, MEAN_RADIUS_M / self.earth_m);
        }
        (near, charts)
    }
}

/// A chart with its origin brought into the period of the textures, each chart shifted against the others so that
/// they do not show the same pattern. Charts lie on the sphere of the mean radius: coordinates on the eye's own sphere are
/// scaled to it, so that the same angle about the Earth's centre is the same place.
fn narrow(view: &ChartView, tile_m: f64, to_mean_sphere: f64) -> Chart {
    use crate::clouds::modulation::{ROTATION, TILE_M};
    let origin = view.origin_m + DVec2::new(3_571.0, 9_173.0) * (view.chart as f64 + 1.0) * 17.0;
    let [c, s] = ROTATION.map(f64::from);
    let map = DVec2::new(c * origin.x - s * origin.y, s * origin.x + c * origin.y) / f64::from(TILE_M);
    let wrap = |v: DVec2, period: f64| [v.x.rem_euclid(period) as f32, v.y.rem_euclid(period) as f32];
    Chart {
        tile_origin_m: wrap(origin, tile_m),
        map_origin: wrap(map, 1.0),
        a: (view.a * to_mean_sphere).as_vec2().into(),
        c: (view.c * to_mean_sphere).as_vec2().into(),
        w: view.w.as_vec3().into(),
        zone: BLEND as f32,
        warp: crate::clouds::warp::phases(origin),
    }
}
