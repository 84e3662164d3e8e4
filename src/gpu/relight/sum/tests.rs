//! Sums on the device against their twin, and one made wrong.

use super::*;
use crate::numeric::hash::{pcg3d, unit};
use crate::passes::relight::sum::SumPart;
use half::f16;

/// Three lights of four components on a box whose edges are odd.
fn some() -> Summed {
    let cells = [7_u32, 6, 5];
    let count = cells.iter().product::<u32>();
    let look = |i: u32, k: u32| unit(pcg3d(i, k, 3)[0]);
    let (mut parts, mut places, mut values) = (Vec::new(), Vec::new(), Vec::new());
    for part in 0..12 {
        let first = places.len() as u32;
        for place in (0..count).filter(|place| look(*place, part) < 0.4) {
            places.push(place);
            // The first coefficient is the mean, large; all others are details.
            values.push(if place == 0 { 40.0 } else { look(place, 50 + part) - 0.5 });
        }
        parts.push(SumPart { first, count: places.len() as u32 - first, weight: 0.1 + look(part, 99), pad0: 0 });
    }
    let shares = (0..4).map(|m| [0.25, 0.3 * look(m, 1), -0.2 * look(m, 2), 0.4 * look(m, 4)]).collect();
    let in_air = (0..count).map(|i| 0.01 + look(i, 7)).collect();
    let head = SumHead { cells, components: 4, lights: 3, levels: 3, ..SumHead::default() };
    Summed { head, parts, places, values, shares, in_air }
}

/// What a device writes into a texture from this level on.
fn on_device(gpu: &Gpu, passes: &SumPasses, summed: &Summed, slot: u32) -> Vec<[f32; 4]> {
    let [nx, ny, nz] = summed.head.cells;
    let texture = super::super::volume(gpu, [nx, ny, nz + slot]);
    passes.run(gpu, summed, &texture, slot);
    let row = 256;
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(row * ny * (nz + slot)),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: Some(ny) };
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
        texture.size(),
    );
    gpu.queue.submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |mapped| mapped.expect("mapped"));
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).expect("done");
    let bytes = buffer.get_mapped_range(..).expect("mapped").to_vec();
    let texel = |x: u32, y: u32, z: u32| -> [f32; 4] {
        let at = (row * (y + ny * z) + 8 * x) as usize;
        std::array::from_fn(|k| f16::from_le_bytes([bytes[at + 2 * k], bytes[at + 2 * k + 1]]).to_f32())
    };
    let cells = (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| (x, y, z + slot))));
    cells.map(|(x, y, z)| texel(x, y, z)).collect()
}

/// Largest difference over the largest value.
fn apart(found: &[[f32; 4]], truth: &[[f32; 4]]) -> f32 {
    let most = truth.as_flattened().iter().fold(0.0_f32, |m, v| m.max(v.abs()));
    let pairs = found.as_flattened().iter().zip(truth.as_flattened());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) / most
}

#[test]
#[cfg_attr(not(gpu_tests), ignore = "no graphics adapter")]
fn a_sum_on_the_device_is_that_of_its_twin() {
    let gpu = Gpu::open().expect("deploy/install-vulkan installs a software adapter");
    let summed = some();
    let truth = summed.quotients();
    assert!(truth.iter().all(|q| q[0] > 0.0), "there is light everywhere");
    let found = on_device(&gpu, &SumPasses::new(&gpu), &summed, 4);
    assert_eq!(found.len(), truth.len());
    // f16 rounds by 2^-11; a device may join a product and a sum in one rounding, which is far less.
    let error = apart(&found, &truth);
    assert!(error < 6e-4, "{error}");
    // Without the last level of the transform it is another field.
    let wrong = pipelines::SUM.replace("3u * head.levels", "3u * (head.levels - 1u)");
    assert_ne!(wrong, pipelines::SUM);
    let error = apart(&on_device(&gpu, &SumPasses::from_source(&gpu, &wrong), &summed, 0), &truth);
    assert!(error > 0.05, "{error}");
}
