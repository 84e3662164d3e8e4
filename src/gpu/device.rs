//! The adapter and its device, and what went wrong with them.

use crate::plan::executor::Fault;
use std::sync::{Arc, Mutex};

/// Bytes of one row of a picture in a buffer, as copies from textures want it.
pub fn row_bytes(width_px: u32, texel: u32) -> u32 {
    (width_px * texel).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)
}

/// An open device.
pub struct Gpu {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    /// Adapter, driver and back end, for people.
    pub name: String,
    /// Format in which light is gathered.
    pub light_format: wgpu::TextureFormat,
    /// Whether the adapter is a program: those run both sides of every branch.
    pub software: bool,
    trouble: Arc<Mutex<Option<Fault>>>,
    instance: wgpu::Instance,
}

impl Gpu {
    /// Opens the best adapter there is; a software one counts.
    pub fn open() -> Result<Self, Fault> {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12;
        // Validation layers are for debugging by hand; wgpu's own validation stays on.
        descriptor.flags = wgpu::InstanceFlags::empty();
        let instance = wgpu::Instance::new(descriptor);
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..Default::default()
        };
        let adapter = pollster::block_on(instance.request_adapter(&options)).map_err(|_| Fault::NoAdapter)?;
        let info = adapter.get_info();
        let software = info.device_type == wgpu::DeviceType::Cpu;
        let name = format!("{} ({} {}, {:?})", info.name, info.driver, info.driver_info, info.backend);
        // 32-bit blending costs twice the bandwidth; exposed values fit f16 (see `BRIGHTEST` in common.wgsl).
        let light_format = wgpu::TextureFormat::Rgba16Float;
        let blendable = adapter.get_texture_format_features(light_format).flags;
        if !blendable.contains(wgpu::TextureFormatFeatureFlags::BLENDABLE) {
            return Err(Fault::Unsupported(format!("{name} cannot blend into 16-bit float targets")));
        }
        let request = adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("stormdeck"),
            required_limits: wgpu::Limits {
                max_texture_dimension_2d: adapter.limits().max_texture_dimension_2d,
                // The light of the largest picture is read back through one buffer of 512 MiB.
                max_buffer_size: adapter.limits().max_buffer_size,
                ..wgpu::Limits::default()
            },
            ..Default::default()
        });
        let (device, queue) =
            pollster::block_on(request).map_err(|error| Fault::Unsupported(format!("{name}: {error}")))?;
        let trouble = Arc::new(Mutex::new(None));
        let report = |trouble: &Arc<Mutex<Option<Fault>>>| {
            let trouble = trouble.clone();
            move |fault: Fault| {
                trouble.lock().unwrap_or_else(std::sync::PoisonError::into_inner).get_or_insert(fault);
            }
        };
        let (lost, failed) = (report(&trouble), report(&trouble));
        device
            .set_device_lost_callback(move |reason, message| lost(Fault::DeviceLost(format!("{reason:?}: {message}"))));
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            failed(match error {
                wgpu::Error::Internal { description, .. } => Fault::DeviceLost(description),
                refused => Fault::Rejected(refused.to_string()),
            });
        }));
        Ok(Self { device, queue, name, light_format, software, trouble, instance })
    }

    /// What has gone wrong, if anything: the device is of no more use then.
    pub fn check(&self) -> Result<(), Fault> {
        match &*self.trouble.lock().unwrap_or_else(std::sync::PoisonError::into_inner) {
            Some(fault) => Err(fault.clone()),
            None => Ok(()),
        }
    }

    /// Whether a picture of this size can be drawn and read back, `texel` bytes for each pixel.
    ///
    /// # Errors
    /// [`Fault::Unsupported`], before the device has been asked for anything.
    pub fn fits(&self, size_px: [u32; 2], texel: u32) -> Result<(), Fault> {
        let (limits, [width, height]) = (self.device.limits(), size_px);
        let refused = |what: String| Err(Fault::Unsupported(format!("a picture of {width}x{height} {what}")));
        let side = limits.max_texture_dimension_2d;
        if width > side || height > side {
            return refused(format!("is too large: at most {side} pixels a side"));
        }
        let bytes = u64::from(row_bytes(width, texel)) * u64::from(height);
        if bytes > limits.max_buffer_size {
            return refused(format!("needs a buffer of {bytes} bytes: at most {}", limits.max_buffer_size));
        }
        Ok(())
    }

    /// Buffers, textures, views and bind groups that somebody holds, as wgpu itself counts them.
    pub fn object_count(&self) -> usize {
        self.instance.generate_report().map_or(0, |report| {
            let hub = report.hub_report();
            [&hub.buffers, &hub.textures, &hub.texture_views, &hub.bind_groups]
                .map(|kind| kind.num_allocated)
                .iter()
                .sum()
        })
    }

    /// A buffer with these contents.
    pub fn buffer(&self, label: &str, bytes: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
        let size = (bytes.len() as u64).max(16).next_multiple_of(16);
        let usage = usage | wgpu::BufferUsages::COPY_DST;
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size,
            usage,
            mapped_at_creation: false,
        });
        self.queue.write_buffer(&buffer, 0, bytes);
        buffer
    }
}
