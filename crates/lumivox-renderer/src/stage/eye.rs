//! One view: its films, its pace, and what it waits for.

use std::collections::VecDeque;

use lumivox_core::Camera;
use lumivox_core::host::Moment;

use super::world::World;
use super::{Lent, ViewFrame};
use crate::error::RenderError;
use crate::live::{LiveSettings, LiveStatus, LiveView};
use crate::pacing::{Pacer, Pass};
use crate::recording::{Recording, Step};

/// Frames whose read-backs may still come.
const MEMORY: usize = 64;

/// One eye of one of the host's pictures.
#[derive(Debug)]
pub struct Eye<W> {
    pub live: LiveView,
    pub pacer: Pacer,
    pub lent: Lent,
    pub world: W,
    /// What was traced last: another one is a new image.
    traced: Option<(Camera, u64, [u32; 2], [f64; 3])>,
    /// When the last frame began, unless it was done then and the engine may have idled since.
    began: Option<Moment>,
    tickets: VecDeque<u64>,
}

/// A frame of an eye, as it was recorded.
#[derive(Clone, Copy, Debug)]
pub struct Trace {
    pub status: LiveStatus,
    pass: Pass,
    /// Pixel samples that were granted for `milliseconds`.
    budget: u64,
    milliseconds: f64,
}

impl<W> Eye<W> {
    pub fn new(
        settings: &LiveSettings,
        world: &World,
        key: W,
        lent: Lent,
        recording: &mut Recording,
    ) -> Result<Self, RenderError> {
        Ok(Self {
            live: LiveView::new(settings, &world.cache, recording)?,
            pacer: Pacer::new(),
            lent,
            world: key,
            traced: None,
            began: None,
            tickets: VecDeque::new(),
        })
    }

    /// Records as much of the picture as fits into the time that it has.
    pub fn record(
        &mut self,
        world: &World,
        frame: &ViewFrame,
        recording: &mut Recording,
    ) -> Result<Trace, RenderError> {
        // The cache's version and not the scene's: a light that reaches no volume starts nothing over.
        let traced =
            Some((frame.camera, world.cache.version(), self.live.film_size(), frame.settings.ambient));
        let before = std::mem::replace(&mut self.traced, traced);
        let pass = if before == traced { Pass::Still } else { Pass::Moving };
        if before.map(|(_, version, ..)| version) != Some(world.cache.version()) {
            self.pacer.changed();
        }
        let milliseconds = frame.budget_milliseconds;
        let now = Moment::now();
        // A clock that stands still, as of a host that gave none, tells nothing of the frame rate.
        if let Some(before) = self.began.filter(|before| now > *before) {
            self.pacer.interval((now - before).as_secs_f64() * 1e3);
        }
        let budget = self.pacer.budget(pass, milliseconds);
        let ViewFrame { camera, settings, host, .. } = frame;
        let status = self.live.record_frame(&world.cache, camera, settings, host, budget, recording)?;
        self.began = (!status.converged).then_some(now);
        Ok(Trace { status, pass, budget, milliseconds })
    }

    /// The light besides the scene's that it was traced with last.
    pub fn ambient(&self) -> Option<[f64; 3]> {
        self.traced.map(|(.., ambient)| ambient)
    }

    /// A frame was recorded under a ticket.
    pub fn ticket_began(&mut self, ticket: u64) {
        self.tickets.push_back(ticket);
        if self.tickets.len() > MEMORY {
            self.tickets.pop_front();
        }
    }

    pub fn has_ticket(&self, ticket: u64) -> bool {
        self.tickets.contains(&ticket)
    }

    /// The frame is on its way to the GPU.
    pub fn executed(&mut self, ticket: u64, trace: &Trace) {
        let Trace { status, pass, budget, milliseconds } = *trace;
        let telling = if status.awaits_turn { 0 } else { status.pixel_samples };
        self.pacer.recorded(ticket, pass, telling, budget, milliseconds);
    }

    pub fn free(self, recording: &mut Recording) {
        self.live.free(recording);
        for id in self.lent.ids() {
            recording.push(Step::Free { id });
        }
    }
}
