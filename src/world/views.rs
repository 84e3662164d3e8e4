//! The views: what they are when nothing is said, and what may be changed.

use crate::geo::Attitude;

use super::check;
use super::command::{Exposure, Frustum, ViewAction, ViewEdit};
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
        frustum: None,
        mirror: [false; 2],
        lights: Default::default(),
        entity: 0,
        carrier: None,
    }
}

/// Creates or changes a view in a list that stays sorted by name.
///
/// # Errors
/// [`Refused`], and nothing has changed: a value out of range, a bad name, one to make that is there or to change that is
/// not, too many views or pixels.
pub fn edit(views: &mut Vec<ViewState>, edit: &ViewEdit) -> Result<(), Refused> {
    check::name("name", &edit.name)?;
    let place = views.binary_search_by(|view| view.name.as_str().cmp(&edit.name));
    let mut view = match (place, edit.action) {
        (Ok(index), ViewAction::Change) => views[index].clone(),
        (Err(_), ViewAction::Create) => default_view(&edit.name),
        (Ok(_), ViewAction::Create) => {
            return Err(Refused::new("name", &edit.name, "a name that is free", "there is such a view; change it"));
        }
        (Err(_), ViewAction::Change) => return Err(unknown(views, &edit.name)),
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
    if let Some(frustum) = edit.frustum {
        check_frustum(&frustum)?;
        view.frustum = Some(frustum);
    }
    view.lights.landing = edit.landing_light.unwrap_or(view.lights.landing);
    view.lights.strobe = edit.strobe.unwrap_or(view.lights.strobe);
    view.mirror = edit.mirror.unwrap_or(view.mirror);
    view.entity = edit.entity.unwrap_or(view.entity);
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
        None => Err(unknown(views, name)),
    }
}

fn check_frustum(frustum: &Frustum) -> Result<(), Refused> {
    let Frustum { left_deg, right_deg, top_deg, bottom_deg } = *frustum;
    for (low_name, low, high_name, high) in
        [("left_deg", left_deg, "right_deg", right_deg), ("bottom_deg", bottom_deg, "top_deg", top_deg)]
    {
        check::within(&format!("frustum.{low_name}"), low, limits::FRUSTUM_DEG)?;
        let least = low + limits::FRUSTUM_SPAN_DEG;
        check::within(&format!("frustum.{high_name}"), high, [least, limits::FRUSTUM_DEG[1]])?;
    }
    Ok(())
}

fn unknown(views: &[ViewState], name: &str) -> Refused {
    let names: Vec<&str> = views.iter().map(|view| view.name.as_str()).collect();
    Refused::new("name", name, format!("one of: {}", names.join(", ")), "no such view")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn making_twice_and_changing_what_is_not_there_are_refused_and_change_nothing() {
        let mut views = vec![default_view(DEFAULT_VIEW)];
        let named = |action, name: &str| ViewEdit {
            action,
            name: name.into(),
            field_of_view_deg: Some(30.0),
            ..ViewEdit::default()
        };
        let before = views.clone();
        for wrong in [named(ViewAction::Create, DEFAULT_VIEW), named(ViewAction::Change, "left")] {
            assert_eq!(edit(&mut views, &wrong).map_err(|refused| refused.field), Err("name".to_owned()));
            assert_eq!(views, before);
        }
        assert_eq!(edit(&mut views, &named(ViewAction::Change, DEFAULT_VIEW)), Ok(()));
        assert_eq!(edit(&mut views, &named(ViewAction::Create, "left")), Ok(()));
        assert_eq!(views.iter().map(|view| view.field_of_view_deg).collect::<Vec<_>>(), [30.0, 30.0]);
    }
}
