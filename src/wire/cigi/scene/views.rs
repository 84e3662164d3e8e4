//! Views: View Control and View Definition, one by one or as groups.
//!
//! View 0 is the server's view "main"; the others are named "view-1", "view-2" and so on, and appear when first spoken of.

use super::half_turn;
use crate::wire::cigi::packets::{ViewControl, ViewDefinition};
use crate::world::command::{Command, Frustum, ViewAction, ViewEdit};
use crate::world::event::Refused;
use crate::world::limits::MAX_VIEWS;
use std::collections::{BTreeMap, BTreeSet};

/// The view that every world begins with.
pub const MAIN: &str = "main";
/// Half-angles of a view of which nothing was said: 60 degrees across, at 16 by 9.
const DEFAULT: Frustum = Frustum { left_deg: -30.0, right_deg: 30.0, top_deg: 17.998, bottom_deg: -17.998 };

/// All views.
#[derive(Clone, Debug)]
pub struct Views {
    size_px: [u32; 2],
    known: BTreeMap<u16, View>,
    /// What was said to a group, for views that join it later.
    groups: BTreeMap<u8, View>,
    changed: BTreeSet<u16>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct View {
    made: bool,
    group: u8,
    entity: u16,
    offset_m: [f64; 3],
    /// Yaw, pitch, roll.
    turn_deg: [f64; 3],
    /// Left, right, top, bottom, where they were given.
    sides_deg: Option<[Option<f64>; 4]>,
    mirror: [bool; 2],
    /// Landing lights and strobes of the own ship.
    lights: [bool; 2],
}

impl Views {
    /// Nothing said of any; their pictures have this size.
    pub fn new(size_px: [u32; 2]) -> Self {
        // The world begins with its view "main".
        let main = View { made: true, ..View::default() };
        Self { size_px, known: BTreeMap::from([(0, main)]), groups: BTreeMap::new(), changed: BTreeSet::new() }
    }

    /// View Control, of a view or of a group.
    ///
    /// # Errors
    /// [`Refused`]: too many views.
    pub fn control(&mut self, packet: &ViewControl) -> Result<(), Refused> {
        let set = |view: &mut View| {
            view.entity = packet.entity_id;
            let offsets = [
                (packet.x_offset_enable, packet.x_offset),
                (packet.y_offset_enable, packet.y_offset),
                (packet.z_offset_enable, packet.z_offset),
            ];
            for (old, (enabled, new)) in view.offset_m.iter_mut().zip(offsets) {
                *old = if enabled { f64::from(new) } else { *old };
            }
            let turns = [
                (packet.yaw_enable, half_turn(f64::from(packet.yaw))),
                (packet.pitch_enable, f64::from(packet.pitch)),
                (packet.roll_enable, half_turn(f64::from(packet.roll))),
            ];
            for (old, (enabled, new)) in view.turn_deg.iter_mut().zip(turns) {
                *old = if enabled { new } else { *old };
            }
        };
        if packet.group_id == 0 {
            set(self.view(packet.view_id)?);
            return Ok(());
        }
        set(self.groups.entry(packet.group_id).or_default());
        for (id, view) in self.known.iter_mut().filter(|(_, view)| view.group == packet.group_id) {
            set(view);
            self.changed.insert(*id);
        }
        Ok(())
    }

    /// View Definition.
    ///
    /// # Errors
    /// As [`Self::control`].
    pub fn define(&mut self, packet: &ViewDefinition) -> Result<(), Refused> {
        let joined = self.groups.get(&packet.group_id).copied().filter(|_| packet.group_id != 0);
        let view = self.view(packet.view_id)?;
        if let Some(group) = joined.filter(|_| view.group != packet.group_id) {
            (view.entity, view.offset_m, view.turn_deg) = (group.entity, group.offset_m, group.turn_deg);
        }
        view.group = packet.group_id;
        let side = |enabled: bool, angle: f32| enabled.then_some(f64::from(angle));
        view.sides_deg = Some([
            side(packet.left_enable, packet.left),
            side(packet.right_enable, packet.right),
            side(packet.top_enable, packet.top),
            side(packet.bottom_enable, packet.bottom),
        ]);
        view.mirror = [packet.mirror_mode & 1 != 0, packet.mirror_mode & 2 != 0];
        Ok(())
    }

    /// Component Control of a view's lights: bit 0 the landing lights, bit 1 the strobes.
    ///
    /// # Errors
    /// As [`Self::control`].
    pub fn lights(&mut self, id: u16, state: u8) -> Result<(), Refused> {
        self.view(id)?.lights = [state & 1 != 0, state & 2 != 0];
        Ok(())
    }

    /// The entities that carry views.
    pub fn carriers(&self) -> BTreeSet<u16> {
        self.known.values().map(|view| view.entity).collect()
    }

    /// Whether some view has changed.
    pub fn changed(&self) -> bool {
        !self.changed.is_empty()
    }

    /// What the world is to hear.
    pub fn commands(&mut self) -> Vec<Command> {
        let changed = std::mem::take(&mut self.changed);
        let mut commands = Vec::new();
        for id in changed {
            let Some(view) = self.known.get_mut(&id) else { continue };
            let action = if std::mem::replace(&mut view.made, true) { ViewAction::Change } else { ViewAction::Create };
            let frustum = view.sides_deg.map(|[left, right, top, bottom]| Frustum {
                left_deg: left.unwrap_or(DEFAULT.left_deg),
                right_deg: right.unwrap_or(DEFAULT.right_deg),
                top_deg: top.unwrap_or(DEFAULT.top_deg),
                bottom_deg: bottom.unwrap_or(DEFAULT.bottom_deg),
            });
            let [yaw_deg, pitch_deg, roll_deg] = view.turn_deg.map(Some);
            commands.push(Command::View(ViewEdit {
                action,
                name: if id == 0 { MAIN.to_owned() } else { format!("view-{id}") },
                size_px: Some(self.size_px),
                offset_m: Some(view.offset_m),
                yaw_deg,
                pitch_deg,
                roll_deg,
                frustum,
                mirror: Some(view.mirror),
                landing_light: Some(view.lights[0]),
                strobe: Some(view.lights[1]),
                entity: Some(view.entity),
                ..ViewEdit::default()
            }));
        }
        commands
    }

    /// A view, made if there is room for it.
    fn view(&mut self, id: u16) -> Result<&mut View, Refused> {
        if self.known.len() >= MAX_VIEWS && !self.known.contains_key(&id) {
            return Err(Refused::new("view_id", id, format!("{MAX_VIEWS} views"), "no room for another view"));
        }
        self.changed.insert(id);
        Ok(self.known.entry(id).or_default())
    }
}
