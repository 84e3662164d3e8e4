//! The read-back ring: pictures are copied into mappable buffers and fetched when they are ready, so that the renderer
//! never waits for the one it has just drawn.

use super::device::{Gpu, row_bytes};
use crate::frame::Pixels;
use crate::plan::executor::{Fault, Finished};
use half::f16;
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use std::time::Instant;

/// Pictures under way at once.
pub const DEPTH: usize = 3;

const WAITING: u8 = 0;
const READY: u8 = 1;
const FAILED: u8 = 2;

/// What a slot holds.
#[derive(Clone, Copy)]
pub enum Content {
    /// Tone-mapped bytes.
    Srgb8,
    /// Exposed light in f16, and the exposure it was multiplied by.
    Light { exposure: f32 },
}

struct Slot {
    ticket: u64,
    size_px: [u32; 2],
    row_bytes: u32,
    content: Content,
    provisional: bool,
    buffer: wgpu::Buffer,
    state: Arc<AtomicU8>,
    submission: wgpu::SubmissionIndex,
}

/// Slots in the order of their submission, and buffers that are free.
#[derive(Default)]
pub struct Ring {
    under_way: VecDeque<Slot>,
    free: Vec<wgpu::Buffer>,
}

impl Ring {
    /// Records the copy of a texture into a buffer of the ring.
    pub fn copy(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        texture: &wgpu::Texture,
        size_px: [u32; 2],
    ) -> (wgpu::Buffer, u32) {
        let texel = texture.format().block_copy_size(None).unwrap_or(4);
        let row_bytes = row_bytes(size_px[0], texel);
        let size = u64::from(row_bytes) * u64::from(size_px[1]);
        let at = self.free.iter().position(|b| b.size() == size);
        let buffer = at.map(|at| self.free.swap_remove(at)).unwrap_or_else(|| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("read-back"),
                size,
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            })
        });
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row_bytes), rows_per_image: None },
            },
            texture.size(),
        );
        (buffer, row_bytes)
    }

    /// Enters a picture whose commands have been submitted.
    pub fn enter(
        &mut self,
        ticket: u64,
        size_px: [u32; 2],
        (content, provisional): (Content, bool),
        (buffer, row_bytes): (wgpu::Buffer, u32),
        submission: wgpu::SubmissionIndex,
    ) {
        let state = Arc::new(AtomicU8::new(WAITING));
        let told = state.clone();
        buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            told.store(if result.is_ok() { READY } else { FAILED }, Ordering::Release);
        });
        self.under_way.push_back(Slot { ticket, size_px, row_bytes, content, provisional, buffer, state, submission });
    }

    /// Pictures that are ready, oldest first; waits for the oldest if asked to.
    ///
    /// # Errors
    /// A picture could not be read back: whoever waits for it has to be told, or waits for ever.
    pub fn collect(&mut self, gpu: &Gpu, wait: bool) -> Result<Vec<Finished>, Fault> {
        let poll = match self.under_way.front() {
            None => return Ok(Vec::new()),
            Some(oldest) if wait => {
                wgpu::PollType::Wait { submission_index: Some(oldest.submission.clone()), timeout: None }
            }
            Some(_) => wgpu::PollType::Poll,
        };
        // A failed poll means a lost device, which the device's callback reports.
        let _ = gpu.device.poll(poll);
        let mut finished = Vec::new();
        while self.under_way.front().is_some_and(|slot| slot.state.load(Ordering::Acquire) != WAITING) {
            let Some(slot) = self.under_way.pop_front() else { break };
            let begin = Instant::now();
            let read = if slot.state.load(Ordering::Acquire) == READY { slot.pixels() } else { None };
            let Some(pixels) = read else {
                return Err(Fault::DeviceLost("a picture could not be read back".to_owned()));
            };
            let (ticket, provisional) = (slot.ticket, slot.provisional);
            finished.push(Finished { ticket, pixels, provisional, read_back: begin.elapsed() });
            slot.buffer.unmap();
            self.free.push(slot.buffer);
            self.free.drain(..self.free.len().saturating_sub(2 * DEPTH));
        }
        Ok(finished)
    }
}

impl Slot {
    fn pixels(&self) -> Option<Pixels> {
        let mapped = self.buffer.get_mapped_range(..).ok()?;
        let [width, height] = self.size_px.map(|n| n as usize);
        let rows = mapped.chunks_exact(self.row_bytes as usize).take(height);
        Some(match self.content {
            Content::Srgb8 => Pixels::Srgb8(rows.flat_map(|row| &row[..width * 4]).copied().collect()),
            Content::Light { exposure } => {
                let value = |b: &[u8]| f16::from_le_bytes([b[0], b[1]]).to_f32() / exposure;
                Pixels::LinearRgb(
                    rows.flat_map(|row| row[..width * 8].chunks_exact(8))
                        .flat_map(|texel| [value(&texel[0..]), value(&texel[2..]), value(&texel[4..])])
                        .collect(),
                )
            }
        })
    }
}
