//! Panics, stopped before they reach the host.

use std::{
    any::Any,
    cell::Cell,
    collections::VecDeque,
    panic::{self, AssertUnwindSafe, PanicHookInfo},
    sync::{
        Mutex, Once, PoisonError,
        atomic::{AtomicUsize, Ordering},
    },
};

/// Messages and places of the last panics. A panic on a thread of the pool goes on on the thread that waits for it,
/// where only its message arrives.
static LAST: Mutex<VecDeque<(String, String)>> = Mutex::new(VecDeque::new());
/// How many fences are up.
static FENCES: AtomicUsize = AtomicUsize::new(0);

const REMEMBERED: usize = 32;

/// Calls `work`; a panic becomes its message and place.
pub(crate) fn guard<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        // A plugin has its own copy of the standard library: the host's hook is another.
        let before = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if FENCES.load(Ordering::Relaxed) == 0 {
                before(info);
            } else {
                remember(info);
            }
        }));
    });
    FENCES.fetch_add(1, Ordering::Relaxed);
    // What a panic left half done is dropped, or belongs to the node, whose next run makes its own.
    let result = panic::catch_unwind(AssertUnwindSafe(work));
    FENCES.fetch_sub(1, Ordering::Relaxed);
    result.map_err(|payload| {
        let message = text_of(&*payload);
        // Its own drop may panic as well; then nothing is lost but memory.
        std::mem::forget(payload);
        match place_of(&message) {
            Some(place) => format!("{message} (at {place})"),
            None => message,
        }
    })
}

fn remember(info: &PanicHookInfo<'_>) {
    thread_local!(static INSIDE: Cell<bool> = const { Cell::new(false) });
    if INSIDE.replace(true) {
        return;
    }
    let place = info.location().map(ToString::to_string).unwrap_or_default();
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    last.truncate(REMEMBERED - 1);
    last.push_front((text_of(info.payload()), place));
    INSIDE.set(false);
}

fn place_of(message: &str) -> Option<String> {
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    let at = last.iter().position(|(said, _)| said == message)?;
    last.remove(at).map(|(_, place)| place).filter(|place| !place.is_empty())
}

fn text_of(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| payload.downcast_ref().cloned()).unwrap_or_else(|| "a panic without words".to_owned())
}
