//! Height files made here, by the encoder of the same crate and by hand: what stands where, and what is refused.

use super::*;
use maker::{Maker, kinds};
use std::io::Cursor;
use tiff::encoder::{TiffEncoder, colortype::Gray32Float, colortype::GrayI16};
use tiff::tags::Tag;

mod maker;

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
    // Rows of a strip as many as a number can hold are all rows.
    directory.write_tag(Tag::RowsPerStrip, u32::MAX).expect("rows of a strip");
    image.write_data(&[-5, 0, 7, 4_000]).expect("heights");
    assert_eq!(decode("a.tif", &bytes.into_inner()).expect("a grid").heights_m, [-5.0, 0.0, 7.0, 4_000.0]);
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut bytes).expect("a file");
    encoder.write_image::<GrayI16>(2, 2, &[0; 4]).expect("an image");
    let said = decode("a.tif", &bytes.into_inner()).expect_err("no place").to_string();
    assert!(said.starts_with("the GeoTIFF's key directory is missing"), "{said}");
}

#[test]
fn every_kind_of_file_gives_the_same_heights() {
    let expected = Maker::plain().heights_m;
    for (what, made) in kinds() {
        let grid = decode("a.tif", &made.bytes()).unwrap_or_else(|wrong| panic!("{what}: {wrong}"));
        assert_eq!((grid.columns, grid.heights_m.len(), grid.west_deg), (20, 360, 8.25), "{what}");
        for (n, (found, expected)) in grid.heights_m.iter().zip(&expected).enumerate() {
            let same = if n == 25 { found.is_nan() } else { *found == f32::from(*expected) };
            assert!(same, "{what}, height {n}: {found}, not {expected}");
        }
    }
    // The second of four tiles is left out: columns 16 to 19 of the first 16 rows are not known.
    let sparse = Maker { tile: Some([16, 16]), left_out: Some(1), ..Maker::plain() };
    let grid = decode("a.tif", &sparse.bytes()).expect("a grid");
    for (n, height_m) in grid.heights_m.iter().enumerate() {
        assert_eq!(height_m.is_nan(), n == 25 || n % 20 >= 16 && n < 320, "{n}");
    }
    // What is packed lies in the file and can be as large as the tags say: memory is not taken first.
    for (tags, expected) in [
        (
            [(324, 4, vec![0xffff_ff00]), (325, 4, vec![2_048])],
            "a strip or tile is 2048 bytes at 4294967040; it must lie",
        ),
        ([(324, 4, vec![8]), (325, 4, vec![300])], "the length of a strip or tile is 300; 2048 bytes cannot be packed"),
    ] {
        let made = Maker { tile: Some([32, 32]), tags: tags.to_vec(), ..Maker::plain() };
        let said = decode("a.tif", &made.bytes()).expect_err("not there").to_string();
        assert!(said.starts_with(expected), "{said}");
    }
    let empty = Maker { tile: Some([32, 32]), left_out: Some(0), ..Maker::plain() };
    let said = decode("a.tif", &empty.bytes()).expect_err("nothing").to_string();
    assert_eq!(said, "the number of strips or tiles with heights is 0; at least 1");
}

#[test]
fn files_of_another_kind_are_refused_by_the_name_of_what_is_wrong() {
    let said = |tags: &[(u16, u16, u64)]| {
        let tags = tags.iter().map(|(tag, kind, value)| (*tag, *kind, vec![*value])).collect();
        decode("a.tif", &Maker { tags, ..Maker::plain() }.bytes()).expect_err("not usable").to_string()
    };
    type One = &'static [(u16, u16, u64)];
    let cases: [(One, &str); 17] = [
        (&[(262, 3, 0)], "the photometric interpretation is 0; 1, BlackIsZero"),
        (&[(284, 3, 2)], "the planar configuration is 2; 1"),
        (&[(274, 3, 3)], "the orientation is 3; 1: rows from the north"),
        (&[(277, 3, 3)], "the samples per pixel is 3; 1"),
        (&[(266, 3, 2)], "the order of bits is 2; 1"),
        (&[(259, 3, 50_000)], "the compression is 50000; 1 (none), 5 (LZW)"),
        (&[(317, 3, 4)], "the predictor is 4; 1 (none)"),
        (&[(258, 3, 12)], "the kind of the heights is format 2, 12 bits; "),
        (&[(339, 3, 3)], "the kind of the heights is format 3, 16 bits; "),
        // What overflowed in the reader of pictures where that is checked: rows as many as a number can be.
        (&[(257, 4, 0xffff_ffff)], "the size is 20 x 4294967295; at most 36000000"),
        (&[(257, 4, 0xffff_ffff), (284, 3, 2)], "the size is 20 x 4294967295; at most 36000000"),
        (&[(256, 4, 0xffff_ffff), (257, 4, 0xffff_ffff)], "the size is 4294967295 x 4294967295"),
        (&[(278, 3, 0)], "the tiles' size is 20 x 0; "),
        (&[(279, 4, 40)], "the number of strips or tiles is 18 with 1 lengths; 18"),
        (&[(278, 3, 4)], "the number of strips or tiles is 18 with 18 lengths; 5"),
        (
            &[(322, 3, 16), (323, 3, 16), (324, 4, 8), (325, 4, 8)],
            "the places of the samples is missing, or there twice",
        ),
        (&[(256, 2, 20)], "the width is no single whole number (tag 256); one"),
    ];
    for (tags, expected) in cases {
        let found = said(tags);
        assert!(found.starts_with(expected), "{tags:?}: {found}");
    }
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
    // Strips and tiles, both headers, both orders, and each way of packing that has a state.
    let some = ["strips", "BigTIFF, big endian, tiles", "deflate", "LZW with differences"];
    for (what, made) in kinds().into_iter().filter(|(what, _)| some.contains(what)) {
        let whole = made.bytes();
        for end in 0..whole.len() {
            let _ = decode("a.tif", &whole[..end]);
        }
        // Header, directory and keys; of the samples every seventh byte.
        for at in (0..480.min(whole.len())).chain((480..whole.len()).step_by(7)) {
            for bent in [0x00, 0x01, 0x7f, 0xff] {
                let mut bytes = whole.clone();
                bytes[at] = bent;
                if let Ok(grid) = decode("a.tif", &bytes) {
                    assert!(grid.columns >= 2 && grid.heights_m.len().is_multiple_of(grid.columns), "{what}: {at}");
                }
            }
        }
    }
}
