//! Entities: what there is, where it is and how it moves; the eye is carried by one of them.

use crate::wire::cigi::layout::{absent, at, bit, bits, fixed, ignored, missing, used};
use crate::wire::cigi::table::packets;

packets! {
    /// State, place and attitude of an entity (CIGI 3.3).
    ///
    /// ```text
    /// CIGI 3.3
    ///    0 |      id = 2      |    size = 48     |              entity_id              |
    ///    4 | . e e d c b a a  | . . . i h h g f  |      alpha       |        .         |
    ///    8 |             entity_type             |              parent_id              |
    ///   12 |                                   roll                                    |
    ///   16 |                                   pitch                                   |
    ///   20 |                                    yaw                                    |
    ///   24 |                                 lat_xoff                                  |
    ///   28 |                                (lat_xoff)                                 |
    ///   32 |                                 lon_yoff                                  |
    ///   36 |                                (lon_yoff)                                 |
    ///   40 |                                 alt_zoff                                  |
    ///   44 |                                (alt_zoff)                                 |
    ///      a entity_state, b attach_state, c collision_detection_enable, d inherit_alpha
    ///      e ground_ocean_clamp, f animation_direction, g animation_loop_mode, h animation_state
    ///      i linear_extrapolation_interpolation_enable
    /// ```
    EntityControl "Entity Control" HostToIg, fixed(2, 48), missing(), {
        /// Entity id: 0 = Ownship, 1..65535.
        entity_id: u16, at(2), absent(), used("which entity; 0 is the ownship");
        /// Entity state: 0 Inactive/Standby, 1 Active, 2 Destroyed.
        entity_state: u8, bits(4, 0, 2), absent(), used("destroyed: forgotten; else it is there");
        /// Attach state: 0 Detach, 1 Attach; 1 = position is relative to parent_id.
        attach_state: bool, bit(4, 2), absent(), used("whether the position is an offset from the parent");
        /// Collision detection enable: 0 Disable, 1 Enable.
        collision_detection_enable: bool, bit(4, 3), absent(), ignored("nothing is there to collide with");
        /// Inherit alpha: 0 Not Inherited, 1 Inherited.
        inherit_alpha: bool, bit(4, 4), absent(), ignored("no models are drawn");
        /// Ground ocean clamp: 0 No Clamp, 1 Non-Conformal, 2 Conformal; ignored when attached.
        ground_ocean_clamp: u8, bits(4, 5, 2), absent(), used("the altitude counts from the ground; 2: the entity also leans with it");
        /// Animation direction: 0 Forward, 1 Backward.
        animation_direction: bool, bit(5, 0), absent(), ignored("no models are drawn");
        /// Animation loop mode: 0 One-Shot, 1 Continuous.
        animation_loop_mode: bool, bit(5, 1), absent(), ignored("no models are drawn");
        /// Animation state: 0 Stop, 1 Pause, 2 Play, 3 Continue.
        animation_state: u8, bits(5, 2, 2), absent(), ignored("no models are drawn");
        /// Linear extrapolation interpolation enable: 0 Disable, 1 Enable; 3.3.
        linear_extrapolation_interpolation_enable: bool, bit(5, 4), absent(), used("with the flag of IG Control: it moves on between messages");
        /// Alpha: 0 transparent..255 opaque.
        alpha: u8 = 255, at(6), absent(), ignored("no models are drawn");
        /// Entity type: 0 = null/no geometry; IG-defined; ownship/camera may use 0.
        entity_type: u16, at(8), absent(), ignored("no models are drawn");
        /// Parent id: entity id; ignored when detached.
        parent_id: u16, at(10), absent(), used("the entity it is attached to");
        /// Roll: deg, -180..180; + right wing down.
        roll: f32, at(12), absent(), used("attitude of the eye");
        /// Pitch: deg, -90..90; + nose up.
        pitch: f32, at(16), absent(), used("attitude of the eye");
        /// Yaw: deg, 0..360; heading, clockwise from true north; child: about Z relative to parent.
        yaw: f32, at(20), absent(), used("attitude of the eye");
        /// Lat xoff: deg / m, lat -90..90 / any; geodetic latitude, or X offset in the parent/entity frame.
        lat_xoff: f64, at(24), absent(), used("position of the eye; an offset when attached");
        /// Lon yoff: deg / m, lon -180..180 / any; geodetic longitude, or Y offset.
        lon_yoff: f64, at(32), absent(), used("position of the eye; an offset when attached");
        /// Alt zoff: m; altitude above MSL (or above terrain when clamped), or Z offset (Z down).
        alt_zoff: f64, at(40), absent(), used("position of the eye; above the ground when clamped; an offset when attached");
    }

    /// State and type of an entity (CIGI 4.0; its place is in Entity Position).
    ///
    /// ```text
    /// CIGI 4.0
    ///    0 |              size = 16              |             id = 0x0025             |
    ///    4 | . . e d c b a a  |      alpha       |              entity_id              |
    ///    8 |   entity_kind    |  entity_domain   |       entity_country_or_type        |
    ///   12 | entity_category  |entity_subcategory| entity_specific  |   entity_extra   |
    ///      a entity_state, b collision_detection_enable, c inherit_alpha, d linear_extrapolation_interpolation_enable
    ///      e extended_entity_type
    /// ```
    EntityState "Entity Control" HostToIg, missing(), fixed(0x0025, 16), {
        /// Entity state: 0 Inactive/Standby, 1 Active, 2 Destroyed.
        entity_state: u8, absent(), bits(4, 0, 2), used("destroyed: forgotten; else it is there");
        /// Collision detection enable: 0 Disable, 1 Enable.
        collision_detection_enable: bool, absent(), bit(4, 2), ignored("nothing is there to collide with");
        /// Inherit alpha: 0 Not Inherited, 1 Inherited.
        inherit_alpha: bool, absent(), bit(4, 3), ignored("no models are drawn");
        /// Linear extrapolation interpolation enable: 0 Disable, 1 Enable.
        linear_extrapolation_interpolation_enable: bool, absent(), bit(4, 4), used("with the flag of IG Control: it moves on between messages");
        /// Extended entity type: 0 Short, 1 Extended; 0: u16 at 10 is an IG-defined type; 1: 8..15 is a SISO/DIS
        /// 7-tuple.
        extended_entity_type: bool, absent(), bit(4, 5), ignored("no models are drawn");
        /// Alpha: 0..255.
        alpha: u8 = 255, absent(), at(5), ignored("no models are drawn");
        /// Entity id: 0 = Ownship.
        entity_id: u16, absent(), at(6), used("which entity; 0 is the ownship");
        /// Entity kind: SISO-REF-010; extended only.
        entity_kind: u8, absent(), at(8), ignored("no models are drawn");
        /// Entity domain: SISO-REF-010; extended only.
        entity_domain: u8, absent(), at(9), ignored("no models are drawn");
        /// Entity country or type: country (extended) or short entity type.
        entity_country_or_type: u16, absent(), at(10), ignored("no models are drawn");
        /// Entity category: SISO-REF-010; extended only.
        entity_category: u8, absent(), at(12), ignored("no models are drawn");
        /// Entity subcategory: SISO-REF-010.
        entity_subcategory: u8, absent(), at(13), ignored("no models are drawn");
        /// Entity specific: SISO-REF-010.
        entity_specific: u8, absent(), at(14), ignored("no models are drawn");
        /// Entity extra: SISO-REF-010.
        entity_extra: u8, absent(), at(15), ignored("no models are drawn");
    }

    /// Where an entity is (CIGI 4.0).
    ///
    /// ```text
    /// CIGI 4.0
    ///    0 |              size = 48              |             id = 0x0001             |
    ///    4 | . . . . . b b a  |        .         |              entity_id              |
    ///    8 |              parent_id              |        .         |        .         |
    ///   12 |                                   roll                                    |
    ///   16 |                                   pitch                                   |
    ///   20 |                                    yaw                                    |
    ///   24 |                                 lat_xoff                                  |
    ///   28 |                                (lat_xoff)                                 |
    ///   32 |                                 lon_yoff                                  |
    ///   36 |                                (lon_yoff)                                 |
    ///   40 |                                 alt_zoff                                  |
    ///   44 |                                (alt_zoff)                                 |
    ///      a attach_state, b ground_ocean_clamp
    /// ```
    EntityPosition "Entity Position" HostToIg, missing(), fixed(0x0001, 48), {
        /// Attach state: 0 Detach, 1 Attach.
        attach_state: bool, absent(), bit(4, 0), used("whether the position is an offset from the parent");
        /// Ground ocean clamp: 0 No Clamp, 1 Non-Conformal, 2 Conformal.
        ground_ocean_clamp: u8, absent(), bits(4, 1, 2), used("the altitude counts from the ground; 2: the entity also leans with it");
        /// Entity id: 0 = Ownship.
        entity_id: u16, absent(), at(6), used("which entity; 0 is the ownship");
        /// Parent id: entity id.
        parent_id: u16, absent(), at(8), used("the entity it is attached to");
        /// Roll: deg, -180..180; + right wing down.
        roll: f32, absent(), at(12), used("attitude of the eye");
        /// Pitch: deg, -90..90; + nose up.
        pitch: f32, absent(), at(16), used("attitude of the eye");
        /// Yaw: deg, 0..360; heading, clockwise from true north; child: about Z relative to parent.
        yaw: f32, absent(), at(20), used("attitude of the eye");
        /// Lat xoff: deg / m, lat -90..90 / any; geodetic latitude, or X offset in the parent/entity frame.
        lat_xoff: f64, absent(), at(24), used("position of the eye; an offset when attached");
        /// Lon yoff: deg / m, lon -180..180 / any; geodetic longitude, or Y offset.
        lon_yoff: f64, absent(), at(32), used("position of the eye; an offset when attached");
        /// Alt zoff: m; altitude above MSL (or above terrain when clamped), or Z offset (Z down).
        alt_zoff: f64, absent(), at(40), used("position of the eye; above the ground when clamped; an offset when attached");
    }

    /// Plays an animation of an entity (CIGI 4.0).
    ///
    /// ```text
    /// CIGI 4.0
    ///    0 |              size = 16              |             id = 0x0026             |
    ///    4 | . . . . d c b a  |      alpha       |              entity_id              |
    ///    8 |            animation_id             |        .         |        .         |
    ///   12 |                              animation_speed                              |
    ///      a animation_state, b animation_frame_position_reset, c animation_loop_mode, d inherit_alpha
    /// ```
    AnimationControl "Animation Control" HostToIg, missing(), fixed(0x0026, 16), {
        /// Animation state: 0 Stop, 1 Play.
        animation_state: bool, absent(), bit(4, 0), ignored("no models are drawn");
        /// Animation frame position reset: 0 Continue, 1 Reset.
        animation_frame_position_reset: bool, absent(), bit(4, 1), ignored("no models are drawn");
        /// Animation loop mode: 0 One-Shot, 1 Continuous.
        animation_loop_mode: bool, absent(), bit(4, 2), ignored("no models are drawn");
        /// Inherit alpha: 0 Not Inherited, 1 Inherited.
        inherit_alpha: bool, absent(), bit(4, 3), ignored("no models are drawn");
        /// Alpha: 0..255.
        alpha: u8 = 255, absent(), at(5), ignored("no models are drawn");
        /// Entity id: as sent by the host.
        entity_id: u16, absent(), at(6), ignored("no models are drawn");
        /// Animation id: as sent by the host.
        animation_id: u16, absent(), at(8), ignored("no models are drawn");
        /// Animation speed: 1 = normal, negative = backward.
        animation_speed: f32, absent(), at(12), ignored("no models are drawn");
    }
}
