//! Structures of any scalar as rows of plain numbers and back, with derivatives by central differences.

use pyo3::prelude::*;
use terra_model::{Dual8, Hooks, LaneDual, Lanes, ModelError, Real};

/// What a function of plain numbers answers.
type Row = Result<Vec<f64>, ModelError>;

/// A scalar that can go through a function of plain numbers.
pub(super) trait Through: Real {
    /// Outputs of `f` at these inputs, derivatives included.
    fn through(inputs: &[Self], f: &dyn Fn(&[f64]) -> Row) -> Result<Vec<Self>, ModelError>;
}

impl Through for f64 {
    fn through(inputs: &[f64], f: &dyn Fn(&[f64]) -> Row) -> Result<Vec<f64>, ModelError> {
        f(inputs)
    }
}

/// y = f(x) + Σ df/dx_k (x_k - Re x_k) over the inputs that carry derivatives.
fn linearised<T: Real<Primal = f64>>(
    inputs: &[T],
    carries: impl Fn(&T) -> bool,
    f: &dyn Fn(&[f64]) -> Row,
) -> Result<Vec<T>, ModelError> {
    let mut x: Vec<f64> = inputs.iter().map(|v| v.primal()).collect();
    let mut out: Vec<T> = f(&x)?.into_iter().map(T::from).collect();
    for (k, input) in inputs.iter().enumerate().filter(|(_, v)| carries(v)) {
        let at = x[k];
        // The cube root of the precision balances truncation and rounding.
        let step = f64::EPSILON.cbrt() * at.abs().max(1e-3);
        x[k] = at + step;
        let above = f(&x)?;
        x[k] = at - step;
        let below = f(&x)?;
        x[k] = at;
        let change = *input - at;
        for ((o, a), b) in out.iter_mut().zip(above).zip(below) {
            *o += change * ((a - b) / (2.0 * step));
        }
    }
    Ok(out)
}

impl Through for Dual8 {
    fn through(inputs: &[Self], f: &dyn Fn(&[f64]) -> Row) -> Result<Vec<Self>, ModelError> {
        linearised(inputs, |v| v.eps.0.is_some_and(|e| e.amax() > 0.0), f)
    }
}

impl Through for Lanes {
    /// Lane by lane; a lane without an answer is NaN, so that its neighbours keep theirs.
    fn through(inputs: &[Self], f: &dyn Fn(&[f64]) -> Row) -> Result<Vec<Self>, ModelError> {
        let rows: Vec<[f64; 8]> = inputs.iter().map(|v| v.0.to_array()).collect();
        let answers: Vec<Row> = (0..8)
            .map(|lane| f(&rows.iter().map(|r| r[lane]).collect::<Vec<f64>>()))
            .collect();
        let length = match answers.iter().flatten().map(Vec::len).next() {
            Some(length) => length,
            // Not one lane has an answer; all for reasons of the same kind.
            None => {
                return answers
                    .into_iter()
                    .collect::<Result<Vec<_>, _>>()
                    .map(|_| vec![]);
            }
        };
        let value = |lane: usize, k: usize| match answers.get(lane) {
            Some(Ok(row)) => row.get(k).copied().unwrap_or(f64::NAN),
            _ => f64::NAN,
        };
        Ok((0..length)
            .map(|k| Lanes(std::array::from_fn(|lane| value(lane, k)).into()))
            .collect())
    }
}

impl Through for LaneDual {
    fn through(inputs: &[Self], f: &dyn Fn(&[f64]) -> Row) -> Result<Vec<Self>, ModelError> {
        let mut x: Vec<Lanes> = inputs.iter().map(|v| v.primal()).collect();
        let out = Lanes::through(&x, f)?;
        let mut out: Vec<Self> = out.into_iter().map(LaneDual::from_primal).collect();
        for (k, input) in inputs.iter().enumerate().filter(|(_, v)| v.varies()) {
            let at = x[k];
            // As for one number.
            let step = (at.abs().max_of(Lanes::from(1e-3))) * f64::EPSILON.cbrt();
            x[k] = at + step;
            let above = Lanes::through(&x, f)?;
            x[k] = at - step;
            let below = Lanes::through(&x, f)?;
            x[k] = at;
            let change = *input - LaneDual::from_primal(at);
            for ((o, a), b) in out.iter_mut().zip(above).zip(below) {
                o.add_scaled(&change, (a - b) / (step * 2.0));
            }
        }
        Ok(out)
    }
}

/// Names of the numbers of a contact, hooks last; [`numbers`] gives them in this order.
pub(super) const CONTACT: [&str; 25] = [
    "slip",
    "normal_load",
    "radius",
    "width",
    "speed",
    "wheel_speed",
    "slip_angle",
    "yaw_rate",
    "path",
    "earlier_passes",
    "side",
    "ahead",
    "wheelbase",
    "time",
    "stiffness",
    "cohesion",
    "friction",
    "shear_modulus",
    "sinkage_exponent",
    "contact_radius",
    "exit_ratio",
    "shear_hump",
    "lug_height",
    "layer_depth",
    "layer_stiffness",
];

/// The numbers of a contact.
pub(super) fn numbers<T: Real>(at: &terra_model::Contact<T>) -> [T; 25] {
    let h = &at.hooks;
    [
        at.slip,
        at.normal_load,
        at.radius,
        at.width,
        at.speed,
        at.wheel_speed,
        at.slip_angle,
        at.yaw_rate,
        at.path,
        at.earlier_passes,
        at.side,
        at.ahead,
        at.wheelbase,
        at.time,
        h.stiffness,
        h.cohesion,
        h.friction,
        h.shear_modulus,
        h.sinkage_exponent,
        h.contact_radius,
        h.exit_ratio,
        h.shear_hump,
        h.lug_height,
        h.layer_depth,
        h.layer_stiffness,
    ]
}

/// A contact of these numbers; the sideways slip inside the stress integral of another is kept.
pub(super) fn contact<T: Real>(n: [T; 25], other: &Hooks<T>) -> terra_model::Contact<T> {
    let [
        slip,
        normal_load,
        radius,
        width,
        speed,
        wheel_speed,
        slip_angle,
        yaw_rate,
        path,
        earlier_passes,
        side,
        ahead,
        wheelbase,
        time,
        stiffness,
        cohesion,
        friction,
        shear_modulus,
        sinkage_exponent,
        contact_radius,
        exit_ratio,
        shear_hump,
        lug_height,
        layer_depth,
        layer_stiffness,
    ] = n;
    terra_model::Contact {
        slip,
        normal_load,
        radius,
        width,
        speed,
        wheel_speed,
        slip_angle,
        yaw_rate,
        path,
        earlier_passes,
        side,
        ahead,
        wheelbase,
        time,
        hooks: Hooks {
            stiffness,
            cohesion,
            friction,
            shear_modulus,
            sinkage_exponent,
            contact_radius,
            exit_ratio,
            shear_hump,
            lug_height,
            layer_depth,
            layer_stiffness,
            lateral_slip: other.lateral_slip,
            pull_only: other.pull_only,
        },
        near: None,
        near_is_here: false,
    }
}

/// One wheel's contact as Python sees it: `slip`, `normal_load`, `radius`, ... and the hooks, all floats.
#[pyclass(frozen, module = "terra")]
pub(crate) struct Contact(pub(super) [f64; 25]);

#[pymethods]
impl Contact {
    fn __getattr__(&self, name: &str) -> PyResult<f64> {
        CONTACT
            .iter()
            .position(|n| *n == name)
            .and_then(|k| self.0.get(k).copied())
            .ok_or_else(|| {
                pyo3::exceptions::PyAttributeError::new_err(format!(
                    "a contact has no '{name}', expected one of {}",
                    CONTACT.join(", ")
                ))
            })
    }

    fn __dir__(&self) -> Vec<&'static str> {
        CONTACT.to_vec()
    }

    fn __repr__(&self) -> String {
        format!(
            "Contact(slip={}, normal_load={}, ...)",
            self.0[0], self.0[1]
        )
    }
}
