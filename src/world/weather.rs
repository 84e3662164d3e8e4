//! Weather that eases: a list of layers and a visibility, each quantity on its own way from its old to its new value.

use crate::clouds::CloudKind;
use crate::geo::Geodetic;

use super::check;
use super::command::{LayerChange, LayerSpec, WeatherEdit};
use super::ease::{Eased, Scale, Span};
use super::event::Refused;
use super::layer::Layer;
use super::limits;
use super::snapshot::{LayerState, WeatherState};

/// Visibility of a new world.
pub const DEFAULT_VISIBILITY_M: f64 = 40_000.0;

/// The weather of the globe or of one region.
#[derive(Clone, Debug, PartialEq)]
pub struct Weather {
    /// Lowest first; those that leave stand last.
    layers: Vec<Layer>,
    visibility_m: Eased,
}

impl Weather {
    /// No cloud, far sight.
    pub fn clear() -> Self {
        Self { layers: Vec::new(), visibility_m: Eased::resting(DEFAULT_VISIBILITY_M, Scale::Logarithmic) }
    }

    /// The weather at a time not before the last edit.
    ///
    /// Layers never overlap: where two would meet on the way, the lower one lifts the upper (those that leave stand last in
    /// the list, so that none that stays is lifted by one that is suddenly gone).
    pub fn at(&self, now_s: f64) -> WeatherState {
        let mut layers: Vec<LayerState> = Vec::with_capacity(self.layers.len());
        for layer in self.layers.iter().filter(|layer| !layer.gone(now_s)) {
            let mut state = layer.at(now_s);
            if let Some(below) = layers.last() {
                state.base_m = state.base_m.max(below.base_m + below.thickness_m);
            }
            layers.push(state);
        }
        WeatherState { layers, visibility_m: self.visibility_m.at(now_s) }
    }

    /// While storm cells come or go: how far the weather around gives way to this one. It does so as cells go, is
    /// gone before other clouds come, and comes back as cells come.
    pub fn turning(&self, now_s: f64) -> Option<f64> {
        let layers = || self.layers.iter().filter(|layer| !layer.gone(now_s));
        if !layers().any(|layer| layer.turns(now_s)) {
            return None;
        }
        let [cells, others] = layers()
            .map(|layer| layer.cell_or_other(now_s))
            .fold([0.0f64; 2], |sum, own| [sum[0].max(own[0]), sum[1].max(own[1])]);
        Some(1.0 - cells * (1.0 - others))
    }

    /// Where the weather goes: its layers, lowest first, when every transition is over.
    pub fn targets(&self) -> Vec<LayerSpec> {
        self.layers.iter().filter(|layer| !layer.leaving()).map(Layer::target).collect()
    }

    /// Applies an edit; `here` is the point at which winds are meant.
    ///
    /// # Errors
    /// [`Refused`], and nothing has changed: a value out of range, too many layers, an index of no layer, a layer over
    /// another in the result.
    pub fn edit(&mut self, edit: &WeatherEdit, here: &Geodetic, now_s: f64) -> Result<(), Refused> {
        check::within("transition_s", edit.transition_s, limits::TRANSITION_S)?;
        if let Some(visibility_m) = edit.visibility_m {
            check::within("visibility_m", visibility_m, limits::VISIBILITY_M)?;
        }
        check::at_most("layers", edit.layers.as_ref().map_or(0, Vec::len), limits::MAX_LAYERS, "layers")?;
        check::at_most("changes", edit.changes.len(), limits::MAX_LAYER_CHANGES, "changes")?;
        let listed = match &edit.layers {
            Some(list) => Some(sorted(list)?),
            None => None,
        };
        let targets = listed.clone().unwrap_or_else(|| self.targets());
        let changed = if edit.changes.is_empty() { None } else { Some(changed(targets, &edit.changes)?) };

        let span = Span { begin_s: now_s, length_s: edit.transition_s };
        if let Some(list) = listed {
            self.replace(&list, here, span);
        }
        if let Some(list) = changed {
            self.change(&list, here, span);
        }
        if let Some(visibility_m) = edit.visibility_m {
            self.visibility_m.aim(visibility_m, span);
        }
        Ok(())
    }

    /// The whole list anew: old and new layers are matched in their order, the rest leave or appear.
    fn replace(&mut self, list: &[LayerSpec], here: &Geodetic, span: Span) {
        self.layers.retain(|layer| !layer.gone(span.begin_s));
        for (layer, spec) in self.layers.iter_mut().zip(list) {
            layer.aim(spec, here, span);
        }
        let matched = self.layers.len().min(list.len());
        self.layers[matched..].iter_mut().for_each(|layer| layer.leave(span));
        self.layers.extend(list[matched..].iter().map(|spec| Layer::appearing(spec, here, span)));
    }

    /// Single layers: only what an edit names turns to a new value, the rest goes on as it was.
    fn change(&mut self, list: &[(LayerSpec, LayerChange)], here: &Geodetic, span: Span) {
        for (layer, (spec, named)) in self.layers.iter_mut().filter(|layer| !layer.leaving()).zip(list) {
            layer.aim_named(spec, named, here, span);
        }
    }
}

/// The layers in the order of their bases, checked; field names count in the given order.
fn sorted(list: &[LayerSpec]) -> Result<Vec<LayerSpec>, Refused> {
    for (index, spec) in list.iter().enumerate() {
        check_layer(&format!("layers[{index}]"), spec)?;
    }
    let mut order: Vec<usize> = (0..list.len()).collect();
    order.sort_by(|&a, &b| list[a].base_m.total_cmp(&list[b].base_m));
    for pair in order.windows(2) {
        refuse_overlap(&format!("layers[{}].base_m", pair[1]), &list[pair[0]], &list[pair[1]])?;
    }
    Ok(order.into_iter().map(|index| list[index]).collect())
}

/// The layers after single changes, checked, each with all that was named of it; field names count the changes.
fn changed(list: Vec<LayerSpec>, changes: &[LayerChange]) -> Result<Vec<(LayerSpec, LayerChange)>, Refused> {
    let count = list.len();
    let mut list: Vec<_> = list.into_iter().map(|spec| (spec, LayerChange::default())).collect();
    for (number, change) in changes.iter().enumerate() {
        let Some((spec, named)) = list.get_mut(change.index) else {
            let limit = if count == 0 { "no layer is there".to_string() } else { format!("0 to {}", count - 1) };
            return Err(Refused::new(format!("changes[{number}].index"), change.index, limit, "no such layer"));
        };
        named.kind = change.kind.or(named.kind);
        named.base_m = change.base_m.or(named.base_m);
        named.thickness_m = change.thickness_m.or(named.thickness_m);
        named.coverage = change.coverage.or(named.coverage);
        named.density = change.density.or(named.density);
        named.wind_speed_mps = change.wind_speed_mps.or(named.wind_speed_mps);
        named.wind_from_deg = change.wind_from_deg.or(named.wind_from_deg);
        spec.kind = named.kind.unwrap_or(spec.kind);
        spec.base_m = named.base_m.unwrap_or(spec.base_m);
        spec.thickness_m = named.thickness_m.unwrap_or(spec.thickness_m);
        spec.coverage = named.coverage.unwrap_or(spec.coverage);
        spec.density = named.density.unwrap_or(spec.density);
        spec.wind_speed_mps = named.wind_speed_mps.unwrap_or(spec.wind_speed_mps);
        spec.wind_from_deg = named.wind_from_deg.unwrap_or(spec.wind_from_deg);
        check_layer(&format!("changes[{number}]"), spec)?;
    }
    list.sort_by(|a, b| a.0.base_m.total_cmp(&b.0.base_m));
    for (index, pair) in list.windows(2).enumerate() {
        refuse_overlap(&format!("layers[{}].base_m", index + 1), &pair[0].0, &pair[1].0)?;
    }
    Ok(list)
}

fn refuse_overlap(field: &str, lower: &LayerSpec, upper: &LayerSpec) -> Result<(), Refused> {
    let top_m = lower.base_m + lower.thickness_m;
    if upper.base_m >= top_m {
        return Ok(());
    }
    Err(Refused::new(field, upper.base_m, format!("at least {top_m}, the top of the layer below"), "layer over layer"))
}

/// Refuses storm cells in the weather of the globe: they need the bounds of a region.
///
/// # Errors
/// [`Refused`] with the field that asks for one.
pub fn refuse_cells(edit: &WeatherEdit) -> Result<(), Refused> {
    let listed = edit.layers.iter().flatten().map(|layer| Some(layer.kind)).enumerate();
    let listed = listed.map(|(k, kind)| (format!("layers[{k}].cloud_type"), kind));
    let changed = edit.changes.iter().map(|change| change.kind).enumerate();
    let changed = changed.map(|(k, kind)| (format!("changes[{k}].cloud_type"), kind));
    match listed.chain(changed).find(|(_, kind)| *kind == Some(CloudKind::StormCell)) {
        None => Ok(()),
        Some((field, _)) => {
            Err(Refused::new(field, "storm_cell", "a genus", "a storm cell stands in a region; give the region"))
        }
    }
}

fn check_layer(field: &str, spec: &LayerSpec) -> Result<(), Refused> {
    for (name, value, limit) in [
        ("base_m", spec.base_m, limits::BASE_M),
        ("thickness_m", spec.thickness_m, limits::THICKNESS_M),
        ("coverage", spec.coverage, limits::COVERAGE),
        ("density", spec.density, limits::DENSITY),
        ("wind_speed_mps", spec.wind_speed_mps, limits::WIND_SPEED_MPS),
        ("wind_from_deg", spec.wind_from_deg, limits::WIND_FROM_DEG),
    ] {
        check::within(&format!("{field}.{name}"), value, limit)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests;
