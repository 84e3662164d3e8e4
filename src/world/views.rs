//! The views: what they are when nothing is said, and what may be changed.

use crate::geo::Attitude;

use super::check;
use super::command::{Exposure, ViewEdit};
use super::event::Refused;
use super::limits;
use super::snapshot::ViewState;

/// Name of the view that a new world has.
pub const DEFAULT_VIEW: &str = "main";

/// A view of which only the name is known: 640 x 360, 60 degrees, at the ownship's origin, looking ahead.
pub fn default_view(name: &str) -> ViewState {
    ViewState {
        name: name.to_string(),
        size_px: [640, 360],
        field_of_view_deg: 60.0,
        offset_m: [0.0; 3],
        attitude: Attitude::default(),
        exposure: Exposure::Automatic,
    }
}

/// Creates or changes a view in a list that stays sorted by name.
///
/// # Errors
/// [`Refused`], and nothing has changed: a value out of range, a bad name, too many views or pixels.
pub fn edit(views: &mut Vec<ViewState>, edit: &ViewEdit) -> Result<(), Refused> {
    check::name("name", &edit.name)?;
    let place = views.binary_search_by(|view| view.name.as_str().cmp(&edit.name));
    let mut view = match place {
        Ok(index) => views[index].clone(),
        Err(_) => default_view(&edit.name),
    };
    if let Some(size_px) = edit.size_px {
        for (index, side) in size_px.into_iter().enumerate() {
            check::within_u32(&format!("size_px[{index}]"), side, limits::VIEW_SIZE_PX)?;
        }
        view.size_px = size_px;
    }
    if let Some(field_of_view_deg) = edit.field_of_view_deg {
        check::within("field_of_view_deg", field_of_view_deg, limits::FIELD_OF_VIEW_DEG)?;
        view.field_of_view_deg = field_of_view_deg;
    }
    if let Some(offset_m) = edit.offset_m {
        for (index, component) in offset_m.into_iter().enumerate() {
            check::within(&format!("offset_m[{index}]"), component, limits::VIEW_OFFSET_M)?;
        }
        view.offset_m = offset_m;
    }
    for (name, value, limit, part) in [
        ("yaw_deg", edit.yaw_deg, limits::TURN_DEG, &mut view.attitude.yaw_rad),
        ("pitch_deg", edit.pitch_deg, limits::PITCH_DEG, &mut view.attitude.pitch_rad),
        ("roll_deg", edit.roll_deg, limits::TURN_DEG, &mut view.attitude.roll_rad),
    ] {
        if let Some(value) = value {
            check::within(name, value, limit)?;
            *part = value.to_radians();
        }
    }
    if let Some(exposure) = edit.exposure {
        if let Exposure::Ev100(value) = exposure {
            check::within("exposure.ev100", value, limits::EV100)?;
        }
        view.exposure = exposure;
    }
    let pixels = |view: &ViewState| u64::from(view.size_px[0]) * u64::from(view.size_px[1]);
    let others: u64 = views.iter().filter(|other| other.name != view.name).map(pixels).sum();
    if others + pixels(&view) > limits::MAX_TOTAL_PIXELS {
        let limit = format!("{} pixels in all views together", limits::MAX_TOTAL_PIXELS);
        return Err(Refused::new("size_px", format!("{:?}", view.size_px), limit, "too many pixels"));
    }
    match place {
        Ok(index) => views[index] = view,
        Err(index) => {
            check::at_most("name", views.len() + 1, limits::MAX_VIEWS, "views")?;
            views.insert(index, view);
        }
    }
    Ok(())
}

/// Removes a view.
///
/// # Errors
/// [`Refused`] when there is none of that name.
pub fn remove(views: &mut Vec<ViewState>, name: &str) -> Result<(), Refused> {
    match views.iter().position(|view| view.name == name) {
        Some(index) => {
            views.remove(index);
            Ok(())
        }
        None => {
            let names: Vec<&str> = views.iter().map(|view| view.name.as_str()).collect();
            Err(Refused::new("name", name, format!("one of: {}", names.join(", ")), "no such view"))
        }
    }
}
