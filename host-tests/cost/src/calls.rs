//! Calculates figures from the list of calls of a run.

use super::CostError;
use super::function::{NodeFunctions, STORE_SAVE, STORE_STEP};
use std::ops::AddAssign;
use stm32_sim::profile::Call;

/// Instructions and cycles of the same calls.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Count {
    /// Executed instructions.
    pub instructions: u64,
    /// Cycles by the timing table.
    pub cycles: u64,
}

impl Count {
    /// The larger one of each.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Self {
            instructions: self.instructions.max(other.instructions),
            cycles: self.cycles.max(other.cycles),
        }
    }

    /// The median of each.
    pub fn middle(counts: &[Self]) -> Option<Self> {
        let of = |part: fn(&Self) -> u64| middle(counts.iter().map(part).collect());
        Some(Self {
            instructions: of(|count| count.instructions)?,
            cycles: of(|count| count.cycles)?,
        })
    }
}

impl From<&Call> for Count {
    fn from(call: &Call) -> Self {
        Self {
            instructions: call.instructions,
            cycles: call.cycles,
        }
    }
}

impl AddAssign for Count {
    fn add_assign(&mut self, other: Self) {
        self.instructions += other.instructions;
        self.cycles += other.cycles;
    }
}

/// The counts of the longest call of a function.
///
/// # Errors
/// It was never called.
pub fn most(calls: &[Call], function: &'static str) -> Result<Count, CostError> {
    let counts = of(calls, function).map(Count::from);
    counts
        .reduce(Count::max)
        .ok_or(CostError::NeverCalled(function))
}

/// The medians of the calls of a function.
///
/// # Errors
/// It was never called.
pub fn median(calls: &[Call], function: &'static str) -> Result<Count, CostError> {
    let counts: Vec<Count> = of(calls, function).map(Count::from).collect();
    Count::middle(&counts).ok_or(CostError::NeverCalled(function))
}

/// The median, the larger of the two middle figures; None for an empty list.
pub fn middle(mut figures: Vec<u64>) -> Option<u64> {
    figures.sort_unstable();
    figures.get(figures.len() / 2).copied()
}

/// The counts in core from the reception of a message: `receive`, and all calls up to the first `is_idle` that returns true.
/// `calls` are in the order of their start.
///
/// # Errors
/// There is no reception, or a call is missing after it.
pub fn exchange(calls: &[Call], node: &NodeFunctions) -> Result<Count, CostError> {
    let of_node = [
        node.receive,
        node.transmit,
        node.is_idle,
        node.tick,
        node.action,
    ];
    let mut turn = calls
        .iter()
        .filter(|call| of_node.contains(&call.function))
        .skip_while(|call| call.function != node.receive)
        .peekable();
    if turn.peek().is_none() {
        return Err(CostError::NeverCalled(node.receive));
    }
    let (mut count, mut transmitted) = (Count::default(), false);
    for call in turn {
        transmitted |= call.function == node.transmit;
        count += call.into();
        if transmitted && call.function == node.is_idle && call.result & 0xFF != 0 {
            return Ok(count);
        }
    }
    Err(CostError::NeverCalled(if transmitted {
        node.is_idle
    } else {
        node.transmit
    }))
}

/// The counts in core of each cyclic frame: the calls up to the `is_idle` that returns true after a `transmit`, without those that had
/// nothing to do before.
pub fn turns(calls: &[Call], node: &NodeFunctions) -> Vec<Count> {
    let of_node = [node.transmit, node.is_idle, node.tick, node.action];
    let (mut turns, mut count, mut transmitted) = (Vec::new(), Count::default(), false);
    for call in calls.iter().filter(|call| of_node.contains(&call.function)) {
        transmitted |= call.function == node.transmit;
        count += call.into();
        if call.function == node.is_idle && call.result & 0xFF != 0 {
            if transmitted {
                turns.push(count);
            }
            (count, transmitted) = (Count::default(), false);
        }
    }
    turns
}

/// The part of an [`exchange`] until the reply is returned: `receive` and all calls up to the first `transmit`.
///
/// # Errors
/// There is no reception, or no `transmit` after it.
pub fn reply(calls: &[Call], node: &NodeFunctions) -> Result<Count, CostError> {
    let of_node = [node.receive, node.transmit];
    let turn = calls
        .iter()
        .filter(|call| of_node.contains(&call.function))
        .skip_while(|call| call.function != node.receive);
    let mut count = Count::default();
    for call in turn {
        count += call.into();
        if call.function == node.transmit {
            return Ok(count);
        }
    }
    let received = count.instructions > 0;
    Err(CostError::NeverCalled(if received {
        node.transmit
    } else {
        node.receive
    }))
}

/// The counts of a save: its start with the record of the parameters, its steps, and the node's handling of its end.
///
/// # Errors
/// One of these calls is missing.
pub fn save(calls: &[Call], node: &NodeFunctions) -> Result<Count, CostError> {
    let first = |function| of(calls, function).next();
    let begin = first(STORE_SAVE).ok_or(CostError::NeverCalled(STORE_SAVE))?;
    let end = first(node.stored).ok_or(CostError::NeverCalled(node.stored))?;
    let mut count = Count::default();
    for part in [STORE_SAVE, STORE_STEP, node.stored] {
        let within: Vec<&Call> = of(calls, part)
            .filter(|call| (begin.start..=end.start).contains(&call.start))
            .collect();
        if within.is_empty() {
            return Err(CostError::NeverCalled(part));
        }
        within.into_iter().for_each(|call| count += call.into());
    }
    Ok(count)
}

fn of<'a>(calls: &'a [Call], function: &'static str) -> impl Iterator<Item = &'a Call> {
    calls.iter().filter(move |call| call.function == function)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NODE: NodeFunctions = NodeFunctions {
        receive: "receive",
        is_idle: "is_idle",
        tick: "tick",
        action: "action",
        transmit: "transmit",
        sample: "sample",
        stored: "stored",
    };

    /// What calls with these instructions cost.
    fn count(instructions: u64) -> Count {
        Count {
            instructions,
            cycles: 2 * instructions,
        }
    }

    /// Consecutive calls with these instructions, each of two cycles.
    fn calls(made: &[(&'static str, u64)]) -> Vec<Call> {
        let mut cycle = 0;
        made.iter()
            .map(|&(function, instructions)| {
                let start = cycle;
                cycle += instructions;
                Call {
                    function,
                    instructions,
                    cycles: 2 * instructions,
                    start,
                    end: cycle,
                    depth: 0,
                    result: 0,
                }
            })
            .collect()
    }

    #[test]
    fn most_and_median_use_calls_of_one_function() {
        let calls = calls(&[("a", 7), ("b", 900), ("a", 5), ("a", 100)]);
        assert_eq!(most(&calls, "a"), Ok(count(100)));
        assert_eq!(median(&calls, "a"), Ok(count(7)));
        assert_eq!(middle(vec![9, 1, 5, 7]), Some(7));
        assert_eq!(middle(Vec::new()), None);
        assert_eq!(most(&calls, "c"), Err(CostError::NeverCalled("c")));
        assert_eq!(median(&calls, "c"), Err(CostError::NeverCalled("c")));
    }

    #[test]
    fn exchange_ends_with_first_idle_node() {
        let mut made = calls(&[
            ("is_idle", 1000),
            ("sample", 1000),
            ("receive", 1),
            ("transmit", 20),
            ("is_idle", 300),
            ("tick", 4000),
            ("is_idle", 50_000),
            ("transmit", 1000),
            ("is_idle", 1000),
        ]);
        made[0].result = 1;
        made[6].result = 1;
        assert_eq!(exchange(&made, &NODE), Ok(count(54_321)));
        assert_eq!(reply(&made, &NODE), Ok(count(21)));
        assert_eq!(
            reply(&made[..3], &NODE),
            Err(CostError::NeverCalled("transmit"))
        );
        assert_eq!(
            reply(&made[..2], &NODE),
            Err(CostError::NeverCalled("receive"))
        );
    }

    #[test]
    fn incomplete_exchange_is_an_error() {
        let missing = |made: &[(&'static str, u64)]| exchange(&calls(made), &NODE);
        let never = |function| Err(CostError::NeverCalled(function));
        assert_eq!(missing(&[("is_idle", 1)]), never("receive"));
        assert_eq!(
            missing(&[("receive", 1), ("is_idle", 1)]),
            never("transmit")
        );
        // The node is never idle.
        let busy = [("receive", 1), ("transmit", 1), ("is_idle", 1)];
        assert_eq!(missing(&busy), never("is_idle"));
    }

    #[test]
    fn save_is_counted_from_start_to_end() {
        let made = [
            (STORE_STEP, 1000),
            (STORE_SAVE, 21),
            (STORE_STEP, 300),
            ("is_idle", 1000),
            (STORE_STEP, 4000),
            ("stored", 50_000),
            (STORE_STEP, 1000),
        ];
        assert_eq!(save(&calls(&made), &NODE), Ok(count(54_321)));
        assert_eq!(
            save(&calls(&made[..5]), &NODE),
            Err(CostError::NeverCalled("stored"))
        );
        let without_save: Vec<_> = made.into_iter().filter(|one| one.0 != STORE_SAVE).collect();
        assert_eq!(
            save(&calls(&without_save), &NODE),
            Err(CostError::NeverCalled(STORE_SAVE))
        );
    }
}
