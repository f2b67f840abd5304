//! The communicating half of a node.

use super::shell::cause;
use super::{Action, BusChange, BusEvent, BusMode, Context, NodeState, Patterns, Protocol, Shell};
use crate::application::{Application, Values};
use crate::can::{Filter, Frame};
use crate::diagnosis::Diagnosis;
use crate::param::Parameters;
use crate::store::{StoreError, Usage};
use crate::time::{Deadline, Instant};
use crate::update::Contact;

/// The communicating half of a node: protocol, parameters and the published values.
///
/// All its methods are short, so a driver can call [`receive`](Self::receive) in the receive interrupt, while the measuring half
/// ([`Acquisition`](super::Acquisition)) calculates in the main loop. The driver prevents that two calls overlap.
pub struct Communication<A: Application, P> {
    pub(super) context: Context<A>,
    pub(super) protocol: P,
    /// The next step of [`tick`](Self::tick).
    step: u8,
}

/// A task for the measuring half. [`Communication::finish`] takes over its values.
pub enum Task<A: Application> {
    /// The parameters have changed: apply them.
    Apply(Parameters<A::Table>),
    /// Readings are missing, also the first one, or the device restarts: switch off the outputs that must not stay on.
    Stale,
}

impl<A: Application, P: Protocol<A>> Communication<A, P> {
    pub(super) const INITIAL: Self = Self {
        context: Context {
            shell: Shell::INITIAL,
            parameters: Parameters::INITIAL,
            values: A::Values::INITIAL,
            saving: None,
            diagnosis: Diagnosis::NONE,
        },
        protocol: P::INITIAL,
        step: 0,
    };

    /// The step after those of the protocol.
    const LAST_STEP: u8 = u8::MAX;

    /// Whether it can take the next received frame. While false, keep the frames: there is no room for a reply, or
    /// it waits for a [task](Self::task), a save or a restart.
    pub fn ready(&self) -> bool {
        self.context.shell.ready(0)
    }

    /// Whether it can take a frame, and takes part in the bus as this mode of the controller needs it. For a driver that checks the node: if
    /// this is false for long although the controller works and its mailboxes are empty, a disturbance has changed the state.
    pub fn serves(&self, mode: BusMode) -> bool {
        let takes_part = match self.context.shell.state() {
            NodeState::Online => mode == BusMode::Normal,
            NodeState::Detecting(_) => mode == BusMode::Listen,
            _ => false,
        };
        takes_part && self.ready()
    }

    /// The [address](Protocol::address) of the node; None while a change of the filters is pending.
    pub fn address(&self) -> Option<u32> {
        if self.context.shell.is_blocked(cause::BUS) {
            return None;
        }
        self.protocol.address()
    }

    /// Processes a received frame: most requests are answered at once, in the queue of frames to send.
    pub fn receive(&mut self, now: Instant, frame: &Frame) {
        match self.context.shell.state() {
            NodeState::Online => self.protocol.receive(&mut self.context, now, frame),
            // The node does not answer the frame by which it detects the bit rate: it was in listen-only mode.
            NodeState::Detecting(_) if P::DETECTS => {
                self.context.shell.found();
                self.join(now);
            }
            _ => {}
        }
    }

    /// Goes online if the bit rate is detected and the protocol has started.
    fn join(&mut self, now: Instant) {
        if P::DETECTS
            && let Some(rate) = self.context.shell.detected()
        {
            self.context.shell.go_online(rate);
            self.change(now, BusChange::Online);
        }
    }

    fn change(&mut self, now: Instant, change: BusChange) {
        self.protocol.bus_changed(&mut self.context, now, change);
    }

    /// Handles an event of the CAN controller.
    pub fn bus(&mut self, now: Instant, event: BusEvent) {
        let shell = &mut self.context.shell;
        let change = match event {
            BusEvent::Error => {
                if P::DETECTS {
                    shell.error();
                }
                None
            }
            BusEvent::BitTime(time) => {
                if P::DETECTS {
                    shell.measured(time);
                }
                None
            }
            BusEvent::Overrun => {
                if A::HAS_DIAGNOSIS {
                    self.context.diagnosis.note_overrun();
                }
                Some(BusChange::Overrun)
            }
            BusEvent::Unsent => Some(BusChange::Unsent),
            BusEvent::State(state) => {
                let recovers = self.protocol.recovers(&self.context.parameters);
                if A::HAS_DIAGNOSIS {
                    self.context.diagnosis.note(shell.bus_state(), state);
                }
                shell.confine(state, recovers)
            }
        };
        if let Some(change) = change
            && self.context.shell.is_running()
        {
            self.change(now, change);
        }
    }

    /// The next task for the measuring half. Call it until it returns None, and [finish](Self::finish) each task.
    pub fn task(&mut self, now: Instant) -> Option<Task<A>> {
        if self.context.shell.is_blocked(cause::PARAMETERS) {
            // `finish` clears it: until then, no frame is taken.
            return Some(Task::Apply(self.context.parameters));
        }
        let shell = &mut self.context.shell;
        (shell.becomes_stale(now) || shell.stops()).then_some(Task::Stale)
    }

    /// Whether a restart is accepted: readings are discarded.
    pub fn is_leaving(&self) -> bool {
        self.context.shell.is_leaving()
    }

    /// Takes over the values of a reading. During a restart they are discarded. Then call [`sampled`](Self::sampled), in a use of its own:
    /// so each use is short, and a frame between the two gets the new values.
    pub fn renew(&mut self, values: &A::Values) {
        if !self.context.shell.is_leaving() {
            self.context.values = *values;
        }
    }

    /// Handles new values of a reading. The first ones start the protocol.
    pub fn sampled(&mut self, now: Instant) {
        if !self.context.shell.is_leaving() {
            self.context.shell.sampled(now);
            self.judge(now);
        }
    }

    /// Publishes the values of a finished task.
    pub fn finish(&mut self, now: Instant, task: &Task<A>, values: &A::Values) {
        match task {
            Task::Apply(_) => {
                self.context.shell.block(cause::PARAMETERS, false);
                self.context.values = *values;
                self.take_over(now);
            }
            Task::Stale => {
                self.context.values = *values;
                self.judge(now);
            }
        }
        self.context.shell.wake_up();
    }

    /// Publishes new values that are neither from a reading nor from a task. During a restart they are discarded.
    pub fn publish(&mut self, now: Instant, values: &A::Values) {
        if !self.context.shell.is_leaving() {
            self.context.values = *values;
            self.take_over(now);
            self.context.shell.wake_up();
        }
    }

    /// Takes over the values of a reading, or of missing readings. With the first ones the protocol starts: no frame has values that
    /// were not measured, unless the accelerometer has failed.
    fn judge(&mut self, now: Instant) {
        let starts = self.context.shell.starts();
        self.take_over(now);
        if starts {
            self.protocol.start(&mut self.context, now);
            self.join(now);
        }
    }

    fn take_over(&mut self, now: Instant) {
        if A::HAS_OUTPUTS
            && !self
                .context
                .shell
                .has_reported(self.context.values.outputs())
        {
            self.context.shell.wake_up();
        }
        // The values of a stopped application are not published: the protocol would report them as faults.
        let shell = &self.context.shell;
        if shell.is_running() && !shell.is_leaving() {
            self.protocol.published(&mut self.context, now);
        }
    }

    /// The parameters to write to nonvolatile memory for [`Action::Save`].
    pub fn image(&self) -> &Parameters<A::Table> {
        let saving = self.context.saving.as_ref();
        saving.unwrap_or(&self.context.parameters)
    }

    /// The usage of the device, this start included; None: the product does not store it.
    pub fn usage(&self) -> Option<Usage> {
        A::HAS_DIAGNOSIS.then_some(self.context.diagnosis.usage)
    }

    /// Replaces the usage.
    pub fn set_usage(&mut self, usage: &Usage) {
        if A::HAS_DIAGNOSIS {
            self.context.diagnosis.usage = *usage;
        }
    }

    /// Handles the result of the save that [`Action::Save`] requested.
    pub fn stored(&mut self, now: Instant, result: Result<(), StoreError>) {
        if let Some(saved) = self.context.saving.take() {
            self.protocol.stored(&mut self.context, now, &saved, result);
            if P::DEFERS {
                self.context.shell.order_deferred(self.context.is_saving());
            }
            self.context.shell.wake_up();
        }
    }

    /// Handles a frame that waited for the end of a save. Returns false if there is none. A deferred frame can begin the next save;
    /// then the other ones continue to wait.
    pub fn resume(&mut self, now: Instant) -> bool {
        let waits = !P::DEFERS
            || self.context.is_saving()
            || self
                .context
                .shell
                .is_blocked(cause::PARAMETERS | cause::LEAVING);
        if !waits && let Some(frame) = self.context.shell.take_deferred() {
            self.receive(now, &frame);
            while self.proceed() {}
            self.context.shell.order_deferred(self.context.is_saving());
            self.context.shell.wake_up();
            return true;
        }
        false
    }

    /// True if [`patterns`](Self::patterns), [`tick`](Self::tick) and [`action`](Self::action) have nothing to do.
    pub fn is_idle(&self, now: Instant) -> bool {
        self.context.shell.is_idle(now)
    }

    /// The patterns of the LEDs, once after each change.
    pub fn patterns(&mut self) -> Option<Patterns> {
        self.context.shell.take_patterns()
    }

    /// Performs a step of the actions of expired timers. Returns true if there is another step. A call of [`action`](Self::action)
    /// follows the last step. Each step is short, so that a driver can handle frames between two steps.
    pub fn tick(&mut self, now: Instant) -> bool {
        let step = self.step;
        self.step = step.wrapping_add(1);
        match step {
            0 => self.context.shell.begin_work(),
            Self::LAST_STEP => {
                let mut earliest = Deadline::NEVER;
                self.protocol.deadlines(&mut earliest);
                self.context.shell.schedule(earliest);
                self.step = 0;
                return false;
            }
            _ => {}
        }
        let runs = self.context.shell.is_running();
        if !runs || !self.protocol.tick(&mut self.context, now, step) {
            self.step = Self::LAST_STEP;
        }
        true
    }

    /// The next action to perform, except [`Action::Leds`]; None if there is none.
    #[must_use]
    pub fn action(&mut self, now: Instant) -> Option<Action> {
        let outputs = A::HAS_OUTPUTS.then(|| self.context.values.outputs());
        let action = self.context.shell.next_action(now, outputs);
        if action.is_some() {
            self.context.shell.wake_up();
        }
        action
    }

    /// Continues an answer that consists of several frames: call it after [`receive`](Self::receive) until it returns false. The
    /// first frame can be sent before the others are built.
    pub fn proceed(&mut self) -> bool {
        self.protocol.proceed(&mut self.context)
    }

    /// Whether [`transmit`](Self::transmit) can have a frame.
    pub fn is_sending(&self) -> bool {
        self.context.shell.is_sending()
    }

    /// Whether the controller must not repeat the next frame of [`transmit`](Self::transmit) after a bit error.
    pub fn sends_once(&self) -> bool {
        P::USES_SENT && self.protocol.sends_once()
    }

    /// The next frame to send. Call it only when a mailbox is free.
    #[must_use]
    pub fn transmit(&mut self) -> Option<Frame> {
        let frame = self.context.shell.transmit();
        if self.protocol.waits_for_room() {
            self.context.shell.wake_up();
        }
        frame
    }

    /// Handles that all mailboxes are empty, because their frames were sent. Call it at least when the last mailbox becomes empty, if
    /// the protocol [needs it](Protocol::USES_SENT).
    pub fn sent(&mut self, now: Instant) {
        if P::USES_SENT && !self.context.shell.is_sending() {
            self.protocol.sent(&mut self.context, now);
        }
    }

    /// Whether the frames in the mailboxes must not be sent any more: a change of the filters is pending, and they have the old address.
    pub fn withdraws(&self) -> bool {
        P::CHANGES_FILTERS && self.context.shell.is_blocked(cause::BUS)
    }

    /// The latest time for the next [`task`](Self::task) or [`tick`](Self::tick).
    pub fn deadline(&self) -> Deadline {
        self.context.shell.deadline()
    }

    /// What the bootloader must know, if the restart is that into it: for [`Platform::update`](super::driver::Platform::update).
    pub fn contact(&self) -> Option<Contact> {
        let context = &self.context;
        let enters = context.shell.enters_bootloader();
        enters.then(|| self.protocol.contact(context)).flatten()
    }

    /// Calls `accept` for each acceptance filter in force.
    pub fn filters(&self, accept: &mut dyn FnMut(Filter)) {
        self.protocol.filters(&self.context, accept);
    }
}
