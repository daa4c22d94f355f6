//! A wheel on a strip of soil cells that remember what was done to them: the grid simulator with its memory.
//!
//! The memory is a [`SoilGrid`] that belongs to the caller. [`GridScm::forces`] reads it and changes nothing, so the same grid
//! gives the same forces as often as it is asked; [`GridScm::roll`] is the one that leaves a rut. No registered model keeps a
//! state of its own.
//!
//! # Equation
//! A wheel whose bottom is z below the untouched surface presses the cell at the angle θ to y = z - R (1 - cos θ). With y_p the
//! depth to which that cell was pressed for good: p = min(k_e (y - y_p), k y^n) where y > y_p, else 0, and k = k_c/b + k_φ. What
//! the elastic part does not take is plastic: y_p becomes y - p/k_e. While the wheel rolls p has γ_d y' added, y' = v tan θ,
//! and is never below 0.
//!
//! A cell in contact is sheared by what the rim goes farther than the ground, j' = |r| v with r = cos θ/(1 - i) - 1, and
//! begins anew when it is touched anew: τ = (c + p tan φ)(1 - e^(-j/K)) against the motion of the rim. p is vertical and τ
//! horizontal: W = b Σ p dx, D = b Σ τ dx, T = b R Σ (τ cos θ + p sin θ) dx.
//!
//! Rolled over virgin soil of a large k_e this is the registered `scm-column`. As there b is the width of the wheel, where
//! the grid simulators take the area over the perimeter of a patch: for a narrow patch 1/b + 1/L in place of 1/b.
//!
//! # Reference
//! R. Krenn, G. Hirzinger, "SCM - a soil contact model for multi-body system simulations", ISTVS 2009 (recalled); A. Tasora
//! et al., Int. J. Vehicle Performance 5(1):60-76, 2019 (k_e and γ_d of the default: recalled).

use std::collections::BTreeMap;

use crate::contact::Contact;
use crate::error::ModelError;
use crate::forces::{Angles, Contributions, Flags, WheelForces};
use crate::guard::guard;
use crate::models::bekker;
use crate::models::slots::checks::{self, Must, Values};
use crate::param::Param;

/// Name in messages.
const NAME: &str = "grid-scm";
/// Steps of a rolling wheel a cell.
const STEPS: f64 = 2.0;
/// Halvings of the sinkage: below rounding in the end.
const HALVINGS: usize = 60;
/// |r| below which the shear stress turns with the direction of the rim, as in `scm-column`.
const TURN: f64 = 0.005;

/// What the soil of one track remembers: how deep each cell was pressed for good, and how far it is sheared.
#[derive(Clone, Debug, PartialEq)]
pub struct SoilGrid {
    cell: f64,
    touched: BTreeMap<i64, Cell>,
}

/// One cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Cell {
    /// y_p \[m\].
    pressed: f64,
    /// j \[m\].
    sheared: f64,
}

impl SoilGrid {
    /// Flat soil that nothing was on, in cells of a length \[m\] along the track; it has no end.
    ///
    /// # Errors
    /// [`ModelError::Contact`] for a length that is not above zero.
    pub fn virgin(cell: f64) -> Result<Self, ModelError> {
        if cell > 0.0 && cell.is_finite() {
            let touched = BTreeMap::new();
            return Ok(SoilGrid { cell, touched });
        }
        Err(ModelError::Contact {
            quantity: "cell",
            value: cell,
            expected: "a length above 0 m",
        })
    }

    /// How deep the soil at a place was pressed for good \[m\]: the rut.
    pub fn rut(&self, position: f64) -> f64 {
        self.at(self.index(position)).pressed
    }

    fn at(&self, index: i64) -> Cell {
        self.touched.get(&index).copied().unwrap_or_default()
    }

    fn index(&self, position: f64) -> i64 {
        (position / self.cell).floor() as i64
    }
}

/// The soil of the grid beside Bekker's and Janosi's parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridScm {
    /// k_e \[Pa/m\].
    pub elastic_stiffness: f64,
    /// γ_d \[Pa s/m\].
    pub damping: f64,
}

impl Default for GridScm {
    fn default() -> Self {
        GridScm {
            elastic_stiffness: 4e7,
            damping: 3e4,
        }
    }
}

/// One cell under the wheel: where, and what acts there.
struct Loaded {
    index: i64,
    sin: f64,
    cos: f64,
    depth: f64,
    /// p without damping, which is what the soil keeps.
    quasi_static: f64,
    pressure: f64,
}

/// Soil and wheel in the numbers of the equations.
struct Wheel {
    stiffness: f64,
    exponent: f64,
    cohesion: f64,
    tan_friction: f64,
    modulus: f64,
    /// R ω/v - 1.
    excess: f64,
    speed: f64,
    radius: f64,
    width: f64,
}

impl GridScm {
    /// k_c, k_φ, n, c, φ and K, in that order.
    pub fn params() -> &'static [Param] {
        bekker::PARAMS.get(..6).unwrap_or_default()
    }

    /// Forces on a wheel that stands at a place \[m\] of the grid, under the load and at the slip and speed of its contact.
    ///
    /// # Errors
    /// As a law's: a value out of range, [`ModelError::NoEquilibrium`]; also [`ModelError::Contact`] for a wheel that spins
    /// in place, which no way along the grid describes.
    pub fn forces(
        &self,
        p: &[f64],
        grid: &SoilGrid,
        position: f64,
        at: &Contact<f64>,
    ) -> Result<WheelForces<f64>, ModelError> {
        let wheel = self.read(p, position, at)?;
        let (sinkage, cells) = self.balance(&wheel, grid, position, at.normal_load)?;
        Ok(wheel.named(grid, sinkage, &cells, at))
    }

    /// Rolls the wheel from one place to another \[m\] and leaves its rut in the grid; the forces at each step, half a cell
    /// long.
    ///
    /// # Errors
    /// As [`GridScm::forces`], and for a way that does not lead forward; the rut up to there is in the grid.
    pub fn roll(
        &self,
        p: &[f64],
        grid: &mut SoilGrid,
        from: f64,
        to: f64,
        at: &Contact<f64>,
    ) -> Result<Vec<WheelForces<f64>>, ModelError> {
        let wheel = self.read(p, to - from, at)?;
        if to < from {
            return Err(ModelError::Contact {
                quantity: "way",
                value: to - from,
                expected: "a way forward",
            });
        }
        let step = grid.cell / STEPS;
        let count = ((to - from) / step).ceil() as usize;
        let mut forces = Vec::with_capacity(count + 1);
        for k in 0..=count {
            let position = from + step * k as f64;
            let (sinkage, cells) = self.balance(&wheel, grid, position, at.normal_load)?;
            forces.push(wheel.named(grid, sinkage, &cells, at));
            self.leave(&wheel, grid, position, &cells, step);
        }
        Ok(forces)
    }

    fn read(&self, p: &[f64], position: f64, at: &Contact<f64>) -> Result<Wheel, ModelError> {
        guard(NAME, Self::params(), p, at)?;
        checks::contact(at)?;
        let quantity = |quantity, value: f64, legal: bool, expected| match legal {
            true => Ok(()),
            false => Err(ModelError::Contact {
                quantity,
                value,
                expected,
            }),
        };
        let (k_e, damping) = (self.elastic_stiffness, self.damping);
        let finite = "a finite value";
        quantity("position", position, position.is_finite(), finite)?;
        let stiff = k_e > 0.0 && k_e.is_finite();
        quantity("elastic_stiffness", k_e, stiff, "a value above 0 Pa/m")?;
        let damped = damping >= 0.0 && damping.is_finite();
        quantity("damping", damping, damped, "a value from 0 Pa s/m on")?;
        let moves = "a wheel that moves along: slip above -1 and below 1";
        quantity("slip", at.slip, at.slip.abs() < 1.0, moves)?;
        let values = Values {
            model: NAME,
            params: Self::params(),
            p,
        };
        let (k_c, k_phi) = (
            values.get("k_c", Must::BeFinite)?,
            values.get("k_phi", Must::BeFinite)?,
        );
        let stiffness = k_c / at.width + k_phi;
        checks::quantity(NAME, "k_c/b + k_phi", stiffness, Must::BePositive)?;
        let exponent = values.get("sinkage_exponent", Must::BePositive)?;
        let cohesion = values.get("cohesion", Must::NotBeNegative)?;
        let friction_angle = values.get("friction_angle", Must::BeAcute)?;
        let modulus = values.get("shear_modulus", Must::BePositive)?;
        Ok(Wheel {
            stiffness,
            exponent,
            cohesion,
            tan_friction: friction_angle.tan(),
            modulus,
            excess: if at.slip < 0.0 {
                at.slip
            } else {
                at.slip / (1.0 - at.slip)
            },
            speed: at.speed.abs(),
            radius: at.radius,
            width: at.width,
        })
    }

    /// What the cells under a wheel of that sinkage carry.
    fn loaded(&self, w: &Wheel, grid: &SoilGrid, position: f64, sinkage: f64) -> Vec<Loaded> {
        let reach = (sinkage * (2.0 * w.radius - sinkage)).max(0.0).sqrt();
        let (first, last) = (grid.index(position - reach), grid.index(position + reach));
        let mut cells = vec![];
        for index in first..=last {
            let sin = ((index as f64 + 0.5) * grid.cell - position) / w.radius;
            let cos = (1.0 - sin * sin).max(0.0).sqrt();
            // 1 - cos θ = sin² θ/(1 + cos θ)
            let depth = sinkage - w.radius * sin * sin / (1.0 + cos);
            let over = depth - grid.at(index).pressed;
            if over <= 0.0 || depth <= 0.0 {
                continue;
            }
            let virgin = w.stiffness * depth.powf(w.exponent);
            let quasi_static = (self.elastic_stiffness * over).min(virgin);
            let rate = w.speed * sin / cos.max(1e-3);
            cells.push(Loaded {
                index,
                sin,
                cos,
                depth,
                quasi_static,
                pressure: (quasi_static + self.damping * rate).max(0.0),
            });
        }
        cells
    }

    /// The sinkage that carries the load: what each cell carries grows with it.
    fn balance(
        &self,
        w: &Wheel,
        grid: &SoilGrid,
        position: f64,
        load: f64,
    ) -> Result<(f64, Vec<Loaded>), ModelError> {
        let carried = |sinkage: f64| {
            let cells = self.loaded(w, grid, position, sinkage);
            let pressures: f64 = cells.iter().map(|c| c.pressure).sum();
            (pressures * w.width * grid.cell, cells)
        };
        let (mut low, mut high) = (0.0, w.radius);
        let (most, mut cells) = carried(high);
        if most < load {
            return Err(ModelError::NoEquilibrium {
                load,
                max_load: most,
            });
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let (found, there) = carried(middle);
            if found < load {
                low = middle;
            } else {
                (high, cells) = (middle, there);
            }
        }
        Ok((high, cells))
    }

    /// Writes what the wheel did over one step into the grid.
    fn leave(&self, w: &Wheel, grid: &mut SoilGrid, position: f64, cells: &[Loaded], step: f64) {
        // What is no longer touched begins anew when it is.
        let reach = grid.index(position - w.radius)..=grid.index(position + w.radius);
        for (index, cell) in grid.touched.range_mut(reach) {
            if cells.binary_search_by_key(index, |c| c.index).is_err() {
                cell.sheared = 0.0;
            }
        }
        for found in cells {
            let cell = grid.touched.entry(found.index).or_default();
            let plastic = found.depth - found.quasi_static / self.elastic_stiffness;
            cell.pressed = cell.pressed.max(plastic);
            cell.sheared += w.over_ground(found.cos).abs() * step;
        }
    }
}

impl Wheel {
    /// r.
    fn over_ground(&self, cos: f64) -> f64 {
        (1.0 + self.excess) * cos - 1.0
    }

    fn named(
        &self,
        grid: &SoilGrid,
        sinkage: f64,
        cells: &[Loaded],
        at: &Contact<f64>,
    ) -> WheelForces<f64> {
        let area = self.width * grid.cell;
        let (mut pull, mut torque) = (0.0, 0.0);
        for c in cells {
            let r = self.over_ground(c.cos);
            let mobilised = -(-grid.at(c.index).sheared / self.modulus).exp_m1();
            let direction = r / r.hypot(TURN);
            let shear = (self.cohesion + c.pressure * self.tan_friction) * mobilised * direction;
            pull += shear * area;
            torque += (shear * c.cos + c.pressure * c.sin) * area * self.radius;
        }
        let angle = |c: Option<&Loaded>| c.map_or(0.0, |c| c.sin.atan2(c.cos));
        let peak = cells
            .iter()
            .max_by(|a, b| a.pressure.total_cmp(&b.pressure));
        WheelForces {
            drawbar_pull: pull,
            resistive_torque: torque,
            lateral_force: 0.0,
            sinkage: Some(sinkage),
            angles: Some(Angles {
                entry: angle(cells.last()),
                exit: angle(cells.first()),
                max_stress: angle(peak),
            }),
            parts: Contributions {
                thrust: pull,
                lug_thrust: 0.0,
                compaction_resistance: 0.0,
                bulldozing_resistance: 0.0,
                other: 0.0,
            },
            flags: Flags {
                braking: at.slip < 0.0,
                apex_limited: false,
                deep_sinkage: sinkage > 0.5 * self.radius,
            },
        }
    }
}

#[cfg(test)]
mod tests;
