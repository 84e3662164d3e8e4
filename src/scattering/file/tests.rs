//! Pins that a basis comes back bit for bit, that shares and torn files work, and that no bytes do harm.

use super::read::{decode, recipe};
use super::*;
use crate::numeric::hash::pcg3d;
use crate::scattering::basis::Basis;
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
    let merge = |shares: &[&[u8]]| {
        let mut joined = Vec::new();
        join(shares.len(), |i| Ok(shares[i]), &mut joined).map(|_| joined)
    };
    assert_eq!(merge(&[&c, &a, &b]).expect("joined"), whole);
    let wrong = |shares: &[&[u8]]| match merge(shares) {
        Err(JoinError::Whole(why) | JoinError::Share(_, why)) => why,
        other => panic!("{other:?}"),
    };
    assert!(matches!(wrong(&[&a, &c]), FileError::Order { .. }));
    assert!(matches!(wrong(&[&a, &a, &b, &c]), FileError::Order { .. }));
    let other = header(&small(Content::Total, false));
    assert_eq!(wrong(&[&a, &other, &b, &c]), FileError::Mixed(1));
    assert!(matches!(wrong(&[&a, &b[..b.len() - 1], &c]), FileError::TooShort(_)));
    assert_eq!(wrong(&[]), FileError::Foreign);
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
            let mut trailer = Trailer::default();
            basis.blocks.iter().for_each(|block| trailer.add(block.squares));
            resumed.extend(trailer.bytes(&basis.recipe));
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

/// Hands its bytes out in small pieces and remembers how many were asked for at once.
struct Drip<'a>(&'a [u8], &'a std::cell::Cell<usize>);

impl std::io::Read for Drip<'_> {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        self.1.set(self.1.get().max(into.len()));
        let some = into.len().min(7).min(self.0.len());
        into[..some].copy_from_slice(&self.0[..some]);
        self.0 = &self.0[some..];
        Ok(some)
    }
}

#[test]
fn a_file_is_read_block_by_block_in_the_memory_of_one() {
    let basis = baked(Width::F16);
    let bytes = write(&basis);
    let longest = (0..basis.blocks.len()).map(|i| block(&basis.recipe, i, &basis.blocks[i]).len()).max();
    let asked = std::cell::Cell::new(0);
    let mut file = Blocks::open(Drip(&bytes, &asked)).expect("a basis");
    assert_eq!(file.recipe(), &basis.recipe);
    asked.set(0);
    let mut found = Vec::new();
    while let Some((light, block)) = file.next_block().expect("sound") {
        assert_eq!(light, found.len());
        found.push(block);
    }
    assert!(file.complete() && file.sound_bytes() == bytes.len() as u64);
    assert_eq!(found, basis.blocks);
    // Room is made for what is read, and doubled now and then: never for the file.
    let longest = longest.expect("some");
    assert!(asked.get() <= 2 * longest.max(8_192) && asked.get() < bytes.len() / 4, "{} {longest}", asked.get());
    // A block that says it is longer than any can be is refused before it is read.
    let mut endless = bytes[..header(&basis.recipe).len()].to_vec();
    endless.extend([0, 0, 0, 0, 255, 255, 255, 127, 0, 0, 0, 0, 0, 0, 0, 0]);
    let refused = Blocks::open(endless.as_slice()).expect("a header").next_block();
    assert!(matches!(refused, Err(FileError::Value { field, .. }) if field == "length of a block"));
    let mut endless = bytes[..12].to_vec();
    endless.extend([255, 255, 255, 127]);
    let refused = Blocks::open(endless.as_slice()).err();
    assert!(matches!(refused, Some(FileError::Value { field, .. }) if field == "length of the header"));
}

#[test]
fn a_trailer_of_other_lights_or_of_another_header_is_refused() {
    let basis = baked(Width::F16);
    let bytes = write(&basis);
    let end = bytes.len() - 48;
    let with = |trailer: Vec<u8>| [&bytes[..end], &trailer[..]].concat();
    let mut fewer = Trailer::default();
    basis.blocks[1..].iter().for_each(|block| fewer.add(block.squares));
    assert!(matches!(read(&with(fewer.bytes(&basis.recipe))), Err(FileError::Order { .. })));
    let mut all = Trailer::default();
    basis.blocks.iter().for_each(|block| all.add(block.squares));
    assert_eq!(read(&with(all.bytes(&basis.recipe))).as_ref(), Ok(&basis));
    let other = all.bytes(&small(Content::Total, false));
    assert!(matches!(read(&with(other)), Err(FileError::Damaged(what)) if what.starts_with("the trailer")));
}
