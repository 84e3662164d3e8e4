//! Pins that a basis comes back bit for bit, that shares and torn files work, and that no bytes do harm.

use super::*;
use crate::numeric::hash::pcg3d;
use crate::scattering::basis::tests::small;

fn baked(width: Width) -> Basis {
    let mut recipe = small(Content::Diffuse, false);
    recipe.packing.width = width;
    Basis::bake(recipe).expect("baked")
}

#[test]
fn a_basis_comes_back_bit_for_bit_in_every_width() {
    for width in [Width::F32, Width::F16, Width::Log8] {
        let basis = baked(width);
        let bytes = write(&basis);
        assert_eq!(read(&bytes).as_ref(), Ok(&basis));
        // What the coefficients take, 36 bytes a light of frame, sums and a count, and the header.
        let extra = bytes.len() - basis.bytes();
        assert!(extra < 36 * basis.blocks.len() + header(&basis.recipe).len() + 64, "{width:?}: {extra}");
    }
    let periodic = Basis::bake(small(Content::Total, true)).expect("baked");
    assert_eq!(read(&write(&periodic)), Ok(periodic));
}

#[test]
fn shares_merge_to_the_whole_in_any_order_and_only_if_they_fit() {
    let recipe = small(Content::Diffuse, false);
    let whole = write(&Basis::bake(recipe.clone()).expect("baked"));
    let share = |index| {
        let mut bytes = header(&recipe);
        recipe
            .bake(recipe.share(index, 3), |light, b| {
                bytes.extend(block(&recipe, light, &b));
                Ok::<(), ()>(())
            })
            .expect("baked");
        bytes
    };
    let (a, b, c) = (share(0), share(1), share(2));
    assert_eq!(merge(&[&c, &a, &b]), Ok(whole.clone()));
    assert!(matches!(merge(&[&a, &c]), Err(FileError::Order { .. })));
    assert!(matches!(merge(&[&a, &a, &b, &c]), Err(FileError::Order { .. })));
    let other = header(&small(Content::Total, false));
    assert_eq!(merge(&[&a, &other, &b, &c]), Err(FileError::Mixed(1)));
    assert!(matches!(read(&a), Err(FileError::Order { .. })), "a share alone is no basis");
}

#[test]
fn a_bake_killed_at_any_moment_goes_on_from_its_last_whole_block() {
    let basis = baked(Width::F16);
    let whole = write(&basis);
    let begin = header(&basis.recipe).len();
    for cut in [begin, begin + 1, begin + 20, begin + (whole.len() - begin) / 2, whole.len() - 1, whole.len()] {
        let contents = scan(&whole[..cut], true).expect("sound");
        assert!(contents.sound_bytes <= cut && contents.complete == (cut == whole.len()));
        let mut resumed = whole[..contents.sound_bytes].to_vec();
        if !contents.complete {
            for light in contents.blocks.len()..basis.blocks.len() {
                resumed.extend(block(&basis.recipe, light, &basis.blocks[light]));
            }
            resumed.extend(trailer(&basis.blocks, &basis.recipe));
        }
        assert_eq!(resumed, whole, "{cut}");
    }
}

#[test]
fn what_is_wrong_is_told() {
    let basis = baked(Width::F32);
    let bytes = write(&basis);
    assert_eq!(read(b""), Err(FileError::Foreign));
    assert_eq!(read(b"PNG and so on, long enough"), Err(FileError::Foreign));
    let mut future = bytes.clone();
    future[8] = 4;
    assert_eq!(read(&future).err(), Some(FileError::Version(4)));
    future[8] = 2;
    assert_eq!(read(&future).err(), Some(FileError::Version(2)), "and a past one: its fields mean something else");
    let mut header_hit = bytes.clone();
    header_hit[30] ^= 1;
    assert_eq!(read(&header_hit), Err(FileError::Damaged("the header".into())));
    let mut block_hit = bytes.clone();
    let at = bytes.len() - 200;
    block_hit[at] ^= 128;
    assert!(matches!(read(&block_hit), Err(FileError::Damaged(what)) if what.starts_with("the block of light")));
    let mut long = bytes.clone();
    long.push(0);
    assert!(matches!(read(&long), Err(FileError::Value { .. })));
}

#[test]
fn no_bytes_do_harm() {
    let basis = baked(Width::Log8);
    let bytes = write(&basis);
    for i in 0..3000_u32 {
        let [a, b, c] = pcg3d(i, 5, 9);
        let mut hit = bytes.clone();
        for k in 0..=(a % 3) {
            // Half of the hits in the header and the first block, where structure is.
            let reach = if i % 2 == 0 { header(&basis.recipe).len() + 400 } else { hit.len() };
            let at = pcg3d(b, k, c)[0] as usize % reach.min(hit.len());
            hit[at] = hit[at].wrapping_add((c >> 3) as u8);
        }
        if i % 5 == 0 {
            hit.truncate(b as usize % hit.len());
        }
        // Refused, or read to what it was (a hit may undo itself): never a panic, never another basis.
        if let Ok(found) = read(&hit) {
            assert_eq!(found, basis, "{i}");
        }
        let _ = scan(&hit, true);
    }
    // Past the checksums: bodies of noise.
    for i in 0..3000_u32 {
        let noise: Vec<u8> = (0..pcg3d(i, 1, 1)[0] % 700).map(|k| (pcg3d(i, 2, k)[0] >> 7) as u8).collect();
        assert!(recipe(&noise).is_err());
        let _ = decode(&noise, &basis.recipe);
    }
}
