//! The clouds and the haze at a point and along a line: the very field that the deck pass draws, asked without a picture.

use crate::clouds::CloudKind;
use crate::clouds::density::DensityVolume;
use crate::geo::Geodetic;
use crate::passes::common::{AIR_SCALE_M, HAZE_SCALE_M};
use crate::passes::deck::field::{Textures, column_bounds, margin};
use crate::plan::{FramePlan, Output, plan};
use crate::world::command::Exposure;
use crate::world::snapshot::{OwnshipState, Snapshot, ViewState};
use glam::Vec3;
use std::sync::{Arc, OnceLock};

/// The field around a point.
pub struct Field {
    plan: FramePlan,
    /// One a layer of the plan.
    volumes: Vec<(Arc<DensityVolume>, &'static [u8])>,
}

impl Field {
    /// The field as an eye at this point has it. The directions below are east, north, up there.
    pub fn around(snapshot: &Snapshot, point: &Geodetic) -> Self {
        let carrier = OwnshipState { position: *point, attitude: Default::default() };
        let view = ViewState {
            name: String::new(),
            size_px: [16, 16],
            field_of_view_deg: 60.0,
            offset_m: [0.0; 3],
            attitude: Default::default(),
            // Any exposure: nothing is drawn.
            exposure: Exposure::Ev100(10.0),
            frustum: None,
            mirror: [false; 2],
            lights: Default::default(),
            entity: 0,
            carrier: Some(carrier),
        };
        let plan = plan(snapshot, &view, Output::LinearRgb);
        let volumes = plan.layers.iter().map(|layer| (DensityVolume::of(layer.kind), bounds(layer.kind))).collect();
        Self { plan, volumes }
    }

    /// Extinction of cloud in 1/m at a range along a direction.
    pub fn cloud_per_m(&self, direction: Vec3, range_m: f32) -> f32 {
        let camera = &self.plan.camera;
        let height_m = camera.height_at(direction.z, range_m);
        let place = direction * range_m + Vec3::new(0.0, 0.0, camera.eye_m);
        let mut sum = 0.0;
        for (layer, (volume, bounds)) in self.plan.layers.iter().zip(&self.volumes) {
            let layer = &layer.layer;
            if height_m < layer.base_m || height_m > layer.base_m + layer.thickness_m {
                continue;
            }
            let textures = Textures::unlit(&volume.shape, bounds);
            // Range 0: with all its detail, as an eye that comes near sees it.
            let found = margin(layer, &textures, camera.earth_m, place, height_m, 0.0);
            sum += layer.extinction_per_m * (found * layer.inverse_edge).clamp(0.0, 1.0);
        }
        sum
    }

    /// Extinction of haze and air in 1/m at the point itself.
    pub fn haze_per_m(&self) -> f32 {
        let camera = &self.plan.camera;
        let share = |scale_m: f32| (-camera.eye_m.max(0.0) / scale_m).exp();
        camera.haze_per_m * share(HAZE_SCALE_M) + camera.air_per_m * share(AIR_SCALE_M)
    }

    /// Lowest base and highest top of the clouds in sight; `None`: there are none.
    pub fn cloud_heights_m(&self) -> Option<[f32; 2]> {
        let layers = self.plan.layers.iter().map(|layer| &layer.layer);
        let heights = layers.map(|layer| [layer.base_m, layer.base_m + layer.thickness_m]);
        heights.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
    }

    /// Height over the ground at a range along a direction.
    pub fn height_m(&self, direction: Vec3, range_m: f32) -> f32 {
        self.plan.camera.height_at(direction.z, range_m)
    }
}

/// Bounds of a genus's columns, made at first use and kept: 16 KiB each.
fn bounds(kind: CloudKind) -> &'static [u8] {
    static KEPT: [OnceLock<Vec<u8>>; CloudKind::COUNT] = [const { OnceLock::new() }; CloudKind::COUNT];
    KEPT[kind.index()].get_or_init(|| column_bounds(&DensityVolume::of(kind).shape))
}
