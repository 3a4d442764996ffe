//! What is computed from something large: kept by its identity, for all scenes, as long as it is there.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

/// Of sources `S`, what a key `K` asks for.
pub(crate) struct Derived<S, K, V>(Mutex<Vec<Known<S, K, V>>>);

type Known<S, K, V> = (Weak<S>, K, Arc<V>);

impl<S, K: PartialEq, V> Derived<S, K, V> {
    pub const fn new() -> Self {
        Self(Mutex::new(Vec::new()))
    }

    /// What was computed before.
    pub fn get(&self, source: &Arc<S>, key: &K) -> Option<Arc<V>> {
        find(&self.lock(), source, key)
    }

    /// The same, computed now if it was not before; and whether it was not. Nothing is locked meanwhile: two threads may
    /// both compute it, but none waits for another that may be waiting for it.
    pub fn get_or(&self, source: &Arc<S>, key: K, compute: impl FnOnce() -> V) -> (Arc<V>, bool) {
        if let Some(known) = self.get(source, &key) {
            return (known, false);
        }
        let computed = Arc::new(compute());
        let mut list = self.lock();
        list.retain(|(source, _, _)| source.strong_count() > 0);
        if let Some(known) = find(&list, source, &key) {
            return (known, true);
        }
        list.push((Arc::downgrade(source), key, computed.clone()));
        (computed, true)
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Known<S, K, V>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn find<S, K: PartialEq, V>(list: &[Known<S, K, V>], source: &Arc<S>, key: &K) -> Option<Arc<V>> {
    // A weak reference keeps the address from being used again.
    let same = |other: &Weak<S>| std::ptr::eq(other.as_ptr(), Arc::as_ptr(source));
    list.iter().find(|(other, k, _)| same(other) && k == key).map(|(_, _, value)| value.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_computed_once_and_goes_with_its_source() {
        let known: Derived<u32, bool, u32> = Derived::new();
        let (a, b) = (Arc::new(1), Arc::new(1));
        assert_eq!(known.get(&a, &true), None);
        assert_eq!(known.get_or(&a, true, || 10), (Arc::new(10), true));
        assert_eq!(known.get_or(&a, true, || 11), (Arc::new(10), false));
        assert_eq!(known.get_or(&a, false, || 12), (Arc::new(12), true));
        assert_eq!(known.get(&b, &true), None, "an equal source is another one");
        let value = Arc::downgrade(&known.get(&a, &true).unwrap());
        drop(a);
        known.get_or(&b, true, || 13);
        assert!(value.upgrade().is_none());
    }
}
