//! Height files made here, by the encoder of the same crate and by hand: what stands where, and what is refused.

use super::*;
use std::io::Cursor;
use tiff::encoder::{TiffEncoder, colortype::Gray32Float, colortype::GrayI16};
use tiff::tags::Tag;

#[test]
fn a_tile_lies_where_its_name_says_with_voids_left_open() {
    let mut bytes = vec![0; 2 * 1_201 * 1_201];
    // The second height of the first row, and the last of the last one.
    bytes[2..4].copy_from_slice(&1_234i16.to_be_bytes());
    let end = bytes.len() - 2;
    bytes[end..].copy_from_slice(&(-32_768i16).to_be_bytes());
    let grid = decode("S03W078.HGT", &bytes).expect("a tile");
    assert_eq!((grid.north_deg, grid.west_deg, grid.columns), (-2.0, -78.0, 1_201));
    assert_eq!((grid.step_south_deg, grid.step_east_deg), (1.0 / 1_200.0, 1.0 / 1_200.0));
    assert_eq!((grid.heights_m[0], grid.heights_m[1], grid.heights_m.len()), (0.0, 1_234.0, 1_201 * 1_201));
    assert!(grid.heights_m.last().is_some_and(|last| last.is_nan()));
    assert_eq!(decode("N47E008.hgt", &bytes[1..]), Err(NoHeights::Length(bytes.len() - 1)));
    for name in ["N4E008", "N47E08x", "X47E008", "N47E181", "N91E008", "N47E0é", "", "tile"] {
        assert!(matches!(decode(&format!("{name}.hgt"), &bytes), Err(NoHeights::Corner(_))), "{name}");
    }
    assert_eq!(decode("N47E008.png", &bytes), Err(NoHeights::Kind("N47E008.png".to_owned())));
}

/// What a GeoTIFF of 4 x 3 heights says of itself.
struct Tags {
    keys: Vec<u16>,
    scale: Vec<f64>,
    tie: Vec<f64>,
    void: Option<&'static str>,
}

/// Latitudes and longitudes of WGS 84, areas.
fn usual() -> Tags {
    let keys = vec![1, 1, 0, 3, 1024, 0, 1, 2, 1025, 0, 1, 1, 2048, 0, 1, 4326];
    let (scale, tie) = (vec![0.5, 0.25, 0.0], vec![0.0, 0.0, 0.0, 8.0, 47.0, 0.0]);
    Tags { keys, scale, tie, void: Some("-9999") }
}

fn geotiff(tags: &Tags) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut bytes).expect("a file");
    let mut image = encoder.new_image::<Gray32Float>(4, 3).expect("an image");
    let directory = image.encoder();
    directory.write_tag(Tag::GeoKeyDirectoryTag, &tags.keys[..]).expect("keys");
    directory.write_tag(Tag::ModelPixelScaleTag, &tags.scale[..]).expect("scale");
    directory.write_tag(Tag::ModelTiepointTag, &tags.tie[..]).expect("tie point");
    if let Some(void) = tags.void {
        directory.write_tag(Tag::GdalNodata, void).expect("void");
    }
    let heights: Vec<f32> = vec![1.0, 2.0, 3.0, 4.5, -9999.0, 6.0, 7.0, 8.0, f32::NAN, 1e30, 11.0, -12.0];
    image.write_data(&heights).expect("heights");
    bytes.into_inner()
}

#[test]
fn a_geotiff_lies_where_its_tags_say() {
    let grid = decode("alps.tif", &geotiff(&usual())).expect("a grid");
    // Areas: the first middle is half a step from the corner that is tied.
    assert_eq!((grid.west_deg, grid.north_deg), (8.25, 46.875));
    assert_eq!((grid.step_east_deg, grid.step_south_deg, grid.columns), (0.5, 0.25, 4));
    assert_eq!(grid.heights_m[..4], [1.0, 2.0, 3.0, 4.5]);
    assert!([4, 8, 9].into_iter().all(|unknown| grid.heights_m[unknown].is_nan()), "{:?}", grid.heights_m);
    assert_eq!((grid.heights_m[5], grid.heights_m[11]), (6.0, -12.0));
    let mut points = usual();
    points.keys[11] = 2;
    points.tie[0] = 1.0;
    let grid = decode("alps.TIFF", &geotiff(&points)).expect("a grid");
    assert_eq!((grid.west_deg, grid.north_deg), (7.5, 47.0));
}

#[test]
fn whole_numbers_are_read_too_and_without_a_place_there_are_no_heights() {
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut bytes).expect("a file");
    let mut image = encoder.new_image::<GrayI16>(2, 2).expect("an image");
    let directory = image.encoder();
    directory.write_tag(Tag::GeoKeyDirectoryTag, &usual().keys[..]).expect("keys");
    directory.write_tag(Tag::ModelPixelScaleTag, &usual().scale[..]).expect("scale");
    directory.write_tag(Tag::ModelTiepointTag, &usual().tie[..]).expect("tie point");
    image.write_data(&[-5, 0, 7, 4_000]).expect("heights");
    assert_eq!(decode("a.tif", &bytes.into_inner()).expect("a grid").heights_m, [-5.0, 0.0, 7.0, 4_000.0]);
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut bytes).expect("a file");
    encoder.write_image::<GrayI16>(2, 2, &[0; 4]).expect("an image");
    let said = decode("a.tif", &bytes.into_inner()).expect_err("no place").to_string();
    assert!(said.starts_with("the GeoTIFF's key directory is missing"), "{said}");
}

#[test]
fn what_cannot_be_used_is_told() {
    let said = |change: fn(&mut Tags)| {
        let mut tags = usual();
        change(&mut tags);
        decode("a.tif", &geotiff(&tags)).expect_err("not usable").to_string()
    };
    assert!(said(|tags| tags.keys[7] = 1).starts_with("the model type is 1; 2, latitudes and longitudes"));
    assert!(said(|tags| tags.keys[15] = 4314).starts_with("the coordinate system is EPSG:4314; 4326"));
    assert!(said(|tags| tags.scale[0] = 0.0).starts_with("the step eastwards is 0; "));
    assert!(said(|tags| tags.scale[1] = f64::NAN).starts_with("the pixel scale is too short or not finite"));
    assert!(said(|tags| tags.tie[4] = 91.0).starts_with("the first height is at 90.875 N"));
    assert!(said(|tags| tags.tie.truncate(3)).starts_with("the tie point is too short"));
    assert!(check_size(1, 5).is_err() && check_size(HEIGHT_SAMPLES, 2).is_err() && check_size(3_601, 3_601).is_ok());
}

#[test]
fn cut_and_bent_files_are_refused_or_read_and_never_panic() {
    let whole = geotiff(&usual());
    for end in 0..whole.len() {
        let _ = decode("a.tif", &whole[..end]);
    }
    for at in 0..whole.len() {
        for bent in [0x00, 0x01, 0x7f, 0xff] {
            let mut bytes = whole.clone();
            bytes[at] = bent;
            if let Ok(grid) = decode("a.tif", &bytes) {
                assert!(grid.columns >= 2 && grid.heights_m.len().is_multiple_of(grid.columns));
            }
        }
    }
}
