//! Regions: the outline of local weather, and `remove_region`.

use crate::wire::limits;
use crate::world::command::RegionShape;
use crate::world::event::Refused;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A rounded rectangle on the globe.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RegionJson {
    /// Name by which later messages mean the same region: letters, digits, `-` and `_`.
    #[schemars(length(min = limits::NAME_LENGTH.min, max = limits::NAME_LENGTH.max), regex(pattern = limits::NAME_PATTERN))]
    pub name: String,
    /// WGS84 latitude of the centre.
    #[schemars(range(min = limits::LATITUDE_DEG.min, max = limits::LATITUDE_DEG.max))]
    pub latitude_deg: f64,
    /// WGS84 longitude of the centre.
    #[schemars(range(min = limits::LONGITUDE_DEG.min, max = limits::LONGITUDE_DEG.max))]
    pub longitude_deg: f64,
    /// Full size towards east, before the rotation.
    #[schemars(range(min = limits::REGION_SIZE_M.min, max = limits::REGION_SIZE_M.max))]
    pub size_east_m: f64,
    /// Full size towards north, before the rotation.
    #[schemars(range(min = limits::REGION_SIZE_M.min, max = limits::REGION_SIZE_M.max))]
    pub size_north_m: f64,
    /// Radius of the rounded corners, at most half the smaller size.
    #[serde(default)]
    #[schemars(range(min = limits::CORNER_RADIUS_M.min, max = limits::CORNER_RADIUS_M.max))]
    pub corner_radius_m: f64,
    /// Rotation, clockwise seen from above.
    #[serde(default)]
    #[schemars(range(min = limits::DIRECTION_DEG.min, max = limits::DIRECTION_DEG.max))]
    pub rotation_deg: f64,
    /// Width outside the outline over which the weather goes over into the surroundings.
    #[serde(default)]
    #[schemars(range(min = limits::REGION_TRANSITION_M.min, max = limits::REGION_TRANSITION_M.max))]
    pub transition_m: f64,
}

/// Removes a region and its weather, easing out. Only the host may send it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RemoveRegionMessage {
    /// The region's name.
    #[schemars(length(min = limits::NAME_LENGTH.min, max = limits::NAME_LENGTH.max), regex(pattern = limits::NAME_PATTERN))]
    pub name: String,
    /// Seconds over which it fades.
    #[serde(default)]
    #[schemars(range(min = limits::TRANSITION_S.min, max = limits::TRANSITION_S.max))]
    pub transition_s: f64,
}

impl TryFrom<RegionJson> for RegionShape {
    type Error = Refused;

    fn try_from(region: RegionJson) -> Result<Self, Refused> {
        let largest_m = 0.5 * region.size_east_m.min(region.size_north_m);
        if region.corner_radius_m > largest_m {
            return Err(Refused::new(
                "corner_radius_m",
                region.corner_radius_m,
                format!("0 to {largest_m}"),
                "a corner's radius is at most half the region's smaller size",
            ));
        }
        let RegionJson {
            name,
            latitude_deg,
            longitude_deg,
            size_east_m,
            size_north_m,
            corner_radius_m,
            rotation_deg,
            transition_m,
        } = region;
        Ok(Self {
            name,
            latitude_deg,
            longitude_deg,
            size_east_m,
            size_north_m,
            corner_radius_m,
            rotation_deg,
            transition_m,
        })
    }
}

impl From<&RegionShape> for RegionJson {
    fn from(shape: &RegionShape) -> Self {
        let RegionShape {
            name,
            latitude_deg,
            longitude_deg,
            size_east_m,
            size_north_m,
            corner_radius_m,
            rotation_deg,
            transition_m,
        } = shape.clone();
        Self {
            name,
            latitude_deg,
            longitude_deg,
            size_east_m,
            size_north_m,
            corner_radius_m,
            rotation_deg,
            transition_m,
        }
    }
}
