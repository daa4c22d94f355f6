//! One number for each channel.

/// Channels that lie in place.
const FEW: usize = 8;

/// One number for each channel, `None` where there is none. Up to eight lie in place, without heap: a filter makes several
/// of these at every step.
#[derive(Clone, Default)]
pub struct Channels {
    /// NaN where there is none.
    few: [f64; FEW],
    /// All of them, where they are more.
    many: Vec<f64>,
    len: usize,
}

impl Channels {
    /// No number in any of `len` channels.
    pub fn none(len: usize) -> Self {
        Channels {
            few: [f64::NAN; FEW],
            many: if len > FEW {
                vec![f64::NAN; len]
            } else {
                Vec::new()
            },
            len,
        }
    }

    /// Number of channels, empty ones included.
    pub fn len(&self) -> usize {
        self.len
    }

    /// True without channels.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The number of one channel.
    #[inline]
    pub fn get(&self, channel: usize) -> Option<f64> {
        self.as_slice()
            .get(channel)
            .copied()
            .filter(|x| !x.is_nan())
    }

    /// The numbers, channel after channel.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = Option<f64>> + ExactSizeIterator + '_ {
        self.as_slice()
            .iter()
            .map(|x| Some(*x).filter(|x| !x.is_nan()))
    }

    /// The channels that have a number, ascending.
    pub fn present(&self) -> impl Iterator<Item = usize> + '_ {
        let numbers = self.as_slice().iter().enumerate();
        numbers.filter(|(_, x)| !x.is_nan()).map(|(i, _)| i)
    }

    /// NaN where there is none.
    #[inline]
    pub(crate) fn as_slice(&self) -> &[f64] {
        self.few.get(..self.len).unwrap_or(&self.many)
    }

    /// Each channel's number from its place in a row.
    #[inline(always)]
    pub(crate) fn pick(&mut self, from: &[f64], places: &[usize]) {
        for (to, &place) in self.as_mut_slice().iter_mut().zip(places) {
            *to = from.get(place).copied().unwrap_or(f64::NAN);
        }
    }

    fn as_mut_slice(&mut self) -> &mut [f64] {
        match self.few.get_mut(..self.len) {
            Some(few) => few,
            None => &mut self.many,
        }
    }

    /// Gives a channel a number; NaN takes it away.
    #[inline]
    pub(crate) fn set(&mut self, channel: usize, value: f64) {
        if let Some(to) = self.as_mut_slice().get_mut(channel) {
            *to = value;
        }
    }
}

impl FromIterator<Option<f64>> for Channels {
    fn from_iter<I: IntoIterator<Item = Option<f64>>>(values: I) -> Self {
        let many: Vec<f64> = values.into_iter().map(|x| x.unwrap_or(f64::NAN)).collect();
        let mut all = Channels::none(many.len());
        for (i, x) in many.into_iter().enumerate() {
            all.set(i, x);
        }
        all
    }
}

impl PartialEq for Channels {
    /// Channels without a number equal each other.
    fn eq(&self, other: &Self) -> bool {
        self.len == other.len && self.iter().eq(other.iter())
    }
}

impl std::fmt::Debug for Channels {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On both sides of what lies in place: what was put in comes out, and nothing where nothing was.
    #[test]
    fn few_and_many_hold_the_same() {
        for len in [0, 1, FEW, FEW + 1, 20] {
            let values = |k: usize| Some(k as f64).filter(|_| k % 3 != 1);
            let mut all: Channels = (0..len).map(values).collect();
            assert_eq!(all.len(), len);
            assert!(all.iter().eq((0..len).map(values)));
            assert!(all.present().eq((0..len).filter(|k| k % 3 != 1)));
            assert_eq!(all.get(len), None);
            assert_eq!(all, all.clone());
            if len > 1 {
                all.set(1, 5.0);
                assert_eq!(all.get(1), Some(5.0));
                all.set(1, f64::NAN);
                assert_eq!(all.get(1), None);
                assert_ne!(all, Channels::none(len));
            }
            assert_ne!(all, Channels::none(len + 1));
        }
    }
}
