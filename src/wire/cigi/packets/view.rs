//! Views: where the eye is on its entity, where it looks, and the frustum of its picture.

use crate::wire::cigi::layout::{at, bit, bits, fixed, ignored, used};
use crate::wire::cigi::table::packets;

packets! {
    /// Attaches a view or a group of views to an entity and turns it.
    ///
    /// ```text
    /// CIGI 3.3
    ///    0 |     id = 16      |    size = 32     |               view_id               |
    ///    4 |     group_id     | . . f e d c b a  |              entity_id              |
    ///    8 |                                 x_offset                                  |
    ///   12 |                                 y_offset                                  |
    ///   16 |                                 z_offset                                  |
    ///   20 |                                   roll                                    |
    ///   24 |                                   pitch                                   |
    ///   28 |                                    yaw                                    |
    ///      a x_offset_enable, b y_offset_enable, c z_offset_enable, d roll_enable
    ///      e pitch_enable, f yaw_enable
    ///
    /// CIGI 4.0
    ///    0 |              size = 40              |             id = 0x000f             |
    ///    4 |     group_id     | . . f e d c b a  |               view_id               |
    ///    8 |              entity_id              |        .         |        .         |
    ///   12 |                                 x_offset                                  |
    ///   16 |                                 y_offset                                  |
    ///   20 |                                 z_offset                                  |
    ///   24 |                                   roll                                    |
    ///   28 |                                   pitch                                   |
    ///   32 |                                    yaw                                    |
    ///   36 |        .         |        .         |        .         |        .         |
    ///      a x_offset_enable, b y_offset_enable, c z_offset_enable, d roll_enable
    ///      e pitch_enable, f yaw_enable
    /// ```
    ViewControl "View Control" HostToIg, fixed(16, 32), fixed(0x000f, 40), {
        /// View id: 0..65535; used when group_id = 0.
        view_id: u16, at(2), at(6), used("which view, where the group is 0");
        /// Group id: 0 = none, 1..255.
        group_id: u8, at(4), at(4), used("all views of this group");
        /// X offset enable: 0 Disable, 1 Enable; 0 = ignore the value of this packet.
        x_offset_enable: bool, bit(5, 0), bit(5, 0), used("whether the packet's x_offset counts");
        /// Y offset enable: 0 Disable, 1 Enable; 0 = ignore the value of this packet.
        y_offset_enable: bool, bit(5, 1), bit(5, 1), used("whether the packet's y_offset counts");
        /// Z offset enable: 0 Disable, 1 Enable; 0 = ignore the value of this packet.
        z_offset_enable: bool, bit(5, 2), bit(5, 2), used("whether the packet's z_offset counts");
        /// Roll enable: 0 Disable, 1 Enable; 0 = ignore the value of this packet.
        roll_enable: bool, bit(5, 3), bit(5, 3), used("whether the packet's roll counts");
        /// Pitch enable: 0 Disable, 1 Enable; 0 = ignore the value of this packet.
        pitch_enable: bool, bit(5, 4), bit(5, 4), used("whether the packet's pitch counts");
        /// Yaw enable: 0 Disable, 1 Enable; 0 = ignore the value of this packet.
        yaw_enable: bool, bit(5, 5), bit(5, 5), used("whether the packet's yaw counts");
        /// Entity id: entity id; entity the view (group) is attached to.
        entity_id: u16, at(6), at(8), used("the entity that carries the view");
        /// X offset: m; + forward.
        x_offset: f32, at(8), at(12), used("place of the eye in the entity's axes");
        /// Y offset: m; + right.
        y_offset: f32, at(12), at(16), used("place of the eye in the entity's axes");
        /// Z offset: m; + down.
        z_offset: f32, at(16), at(20), used("place of the eye in the entity's axes");
        /// Roll: deg, -180..180.
        roll: f32, at(20), at(24), used("attitude of the view against the entity");
        /// Pitch: deg, -90..90.
        pitch: f32, at(24), at(28), used("attitude of the view against the entity");
        /// Yaw: deg, 0..360.
        yaw: f32, at(28), at(32), used("attitude of the view against the entity");
    }

    /// The frustum of a view, and the group it belongs to.
    ///
    /// ```text
    /// CIGI 3.3
    ///    0 |     id = 21      |    size = 32     |               view_id               |
    ///    4 |     group_id     | g g f e d c b a  | k k k j i h h h  |        .         |
    ///    8 |                                   near                                    |
    ///   12 |                                    far                                    |
    ///   16 |                                   left                                    |
    ///   20 |                                   right                                   |
    ///   24 |                                    top                                    |
    ///   28 |                                  bottom                                   |
    ///      a near_enable, b far_enable, c left_enable, d right_enable
    ///      e top_enable, f bottom_enable, g mirror_mode, h pixel_replication_mode
    ///      i projection_type, j reorder, k view_type
    ///
    /// CIGI 4.0
    ///    0 |              size = 40              |             id = 0x0014             |
    ///    4 |               view_id               |     group_id     | g g f e d c b a  |
    ///    8 | k k k j i h h h  |        .         |        .         |        .         |
    ///   12 |                                   near                                    |
    ///   16 |                                    far                                    |
    ///   20 |                                   left                                    |
    ///   24 |                                   right                                   |
    ///   28 |                                    top                                    |
    ///   32 |                                  bottom                                   |
    ///   36 |        .         |        .         |        .         |        .         |
    ///      a near_enable, b far_enable, c left_enable, d right_enable
    ///      e top_enable, f bottom_enable, g mirror_mode, h pixel_replication_mode
    ///      i projection_type, j reorder, k view_type
    /// ```
    ViewDefinition "View Definition" HostToIg, fixed(21, 32), fixed(0x0014, 40), {
        /// View id: 0..65535.
        view_id: u16, at(2), at(4), used("which view; a new one is made");
        /// Group id: 0 = none, 1..255.
        group_id: u8, at(4), at(6), used("puts the view into this group");
        /// Near enable: 0 Disable, 1 Enable; 0 = keep the IG default for this side.
        near_enable: bool, bit(5, 0), bit(7, 0), ignored("nothing near is drawn, and the sky has no end");
        /// Far enable: 0 Disable, 1 Enable; 0 = keep the IG default for this side.
        far_enable: bool, bit(5, 1), bit(7, 1), ignored("nothing near is drawn, and the sky has no end");
        /// Left enable: 0 Disable, 1 Enable; 0 = keep the IG default for this side.
        left_enable: bool, bit(5, 2), bit(7, 2), used("whether the packet's left counts");
        /// Right enable: 0 Disable, 1 Enable; 0 = keep the IG default for this side.
        right_enable: bool, bit(5, 3), bit(7, 3), used("whether the packet's right counts");
        /// Top enable: 0 Disable, 1 Enable; 0 = keep the IG default for this side.
        top_enable: bool, bit(5, 4), bit(7, 4), used("whether the packet's top counts");
        /// Bottom enable: 0 Disable, 1 Enable; 0 = keep the IG default for this side.
        bottom_enable: bool, bit(5, 5), bit(7, 5), used("whether the packet's bottom counts");
        /// Mirror mode: 0 None, 1 Horizontal, 2 Vertical, 3 Both.
        mirror_mode: u8, bits(5, 6, 2), bits(7, 6, 2), used("the picture is mirrored");
        /// Pixel replication mode: 0 None, 1 1x2, 2 2x1, 3 2x2, 4-7 IG-defined.
        pixel_replication_mode: u8, bits(6, 0, 3), bits(8, 0, 3), ignored("pictures are sent as they are drawn");
        /// Projection type: 0 Perspective, 1 Orthographic Parallel.
        projection_type: bool, bit(6, 3), bit(8, 3), ignored("always perspective: an orthographic sky has no meaning");
        /// Reorder: 0 No Reorder, 1 Bring to Top.
        reorder: bool, bit(6, 4), bit(8, 4), ignored("views are separate pictures, none over another");
        /// View type: 0..7; IG-defined (OTW, IR, ...).
        view_type: u8, bits(6, 5, 3), bits(8, 5, 3), ignored("the eye is the only sensor");
        /// Near: m, >0, < far; near plane, along the view axis.
        near: f32, at(8), at(12), ignored("nothing near is drawn, and the sky has no end");
        /// Far: m, > near; far plane.
        far: f32, at(12), at(16), ignored("nothing near is drawn, and the sky has no end");
        /// Left: deg, -90..90, < right; left half-angle, normally negative.
        left: f32, at(16), at(20), used("half-angle of the frustum, symmetric or not");
        /// Right: deg, -90..90, > left; right half-angle.
        right: f32, at(20), at(24), used("half-angle of the frustum, symmetric or not");
        /// Top: deg, -90..90, > bottom; top half-angle.
        top: f32, at(24), at(28), used("half-angle of the frustum, symmetric or not");
        /// Bottom: deg, -90..90, < top; bottom half-angle, normally negative.
        bottom: f32, at(28), at(32), used("half-angle of the frustum, symmetric or not");
    }
}
