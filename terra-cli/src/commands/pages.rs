//! `terra pages`: a page of Markdown for every model and effect, made from what is registered.

use std::fmt::Write as _;
use std::fs;

use std::path::Path;
use std::sync::Arc;

use terra_data::atomic_write;
use terra_model::models::{Filling, Slots};
use terra_model::{AnyEffect, AnyModel, Law, Param, Registry, Scale, Scope, Touch, natural_symbol};

use super::lists::{forms, named_models};
use crate::error::CliError;
use crate::output::{self, short};

/// A page: its file below the folder, and its text.
struct Page {
    file: String,
    text: String,
}

pub(crate) fn run(folder: &Path) -> Result<(), CliError> {
    let pages = pages(&Registry::builtin());
    for page in &pages {
        let path = folder.join(&page.file);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).map_err(|reason| CliError::Write {
                target: parent.display().to_string(),
                reason,
            })?;
        }
        atomic_write(&path, |out| out.write_all(page.text.as_bytes()))?;
    }
    output::stdout(&format!("{} pages in {}\n", pages.len(), folder.display()))
}

fn pages(registry: &Registry) -> Vec<Page> {
    let effects = forms(registry);
    let mut names: Vec<&str> = vec![];
    for (effect, _) in &effects {
        if !names.contains(&effect.name()) {
            names.push(effect.name());
        }
    }
    let models: Vec<(&Arc<dyn AnyModel>, bool)> = named_models(registry).collect();
    let mut out = vec![models_index(&models), effects_index(&effects, &names)];
    for (model, rival) in &models {
        out.push(model_page(model, *rival, &effects, &names));
    }
    for name in &names {
        let of_name: Vec<_> = effects.iter().filter(|(e, _)| e.name() == *name).collect();
        out.push(effect_page(name, &of_name, &models));
    }
    out
}

fn models_index(models: &[(&Arc<dyn AnyModel>, bool)]) -> Page {
    let mut text = "# Terrain models\n\n| model | what it is |\n|---|---|\n".to_owned();
    for (m, _) in models {
        let _ = writeln!(
            text,
            "| [{0}](models/{0}.md) | {1} |",
            m.name(),
            m.summary()
        );
    }
    text.push_str(
        "\nPressure and shear laws of a wheel can be chosen one by one, as `wheel[:pressure[:shear]]`; each page lists those that \
         its wheel takes.\n",
    );
    Page {
        file: "models.md".to_owned(),
        text,
    }
}

fn effects_index(effects: &[(Arc<dyn AnyEffect>, bool)], names: &[&str]) -> Page {
    let mut text =
        "# Effects\n\n| effect | what happens | isolated by |\n|---|---|---|\n".to_owned();
    for name in names {
        if let Some((e, _)) = effects.iter().find(|(e, _)| e.name() == *name) {
            let (what, by) = (cell(e.summary()), cell(e.isolated_by()));
            let _ = writeln!(text, "| [{name}](effects/{name}.md) | {what} | {by} |");
        }
    }
    Page {
        file: "effects.md".to_owned(),
        text,
    }
}

/// Text in lines of at most 100 characters, broken at spaces.
fn lines(text: &str) -> String {
    let mut out = String::new();
    let mut length = 0;
    for word in text.split(' ') {
        let more = word.chars().count() + 1;
        if length > 0 {
            out.push(if length + more > 100 { '\n' } else { ' ' });
            length = if length + more > 100 { 0 } else { length };
        }
        out.push_str(word);
        length += more;
    }
    out
}

/// A cell of a table: bars end cells.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

fn range(p: &Param) -> String {
    let end = |x: f64| {
        if x.is_finite() {
            short(x)
        } else {
            if x > 0.0 { "∞" } else { "-∞" }.to_owned()
        }
    };
    format!("{} to {}", end(p.min), end(p.max))
}

fn parameters(params: &[Param]) -> String {
    let mut text =
        "| parameter | symbol | unit | range | prior sd | meaning |\n|---|---|---|---|---|---|\n"
            .to_owned();
    for p in params {
        let prior = match p.scale {
            Scale::Log => format!("{} of its logarithm", short(p.prior_sd)),
            Scale::Linear => short(p.prior_sd),
        };
        let _ = writeln!(
            text,
            "| `{}` | {} | {} | {} | {prior} | {} |",
            p.name,
            p.symbol,
            p.unit,
            range(p),
            cell(p.doc)
        );
    }
    text
}

fn laws(title: &str, laws: &[Filling]) -> String {
    let mut text =
        format!("\n| {title} law | what it is | equation | source |\n|---|---|---|---|\n");
    for law in laws {
        let mark = if law.default { " (default)" } else { "" };
        let _ = writeln!(
            text,
            "| `{}`{mark} | {} | `{}` | {} |",
            law.name,
            cell(law.summary),
            cell(law.equation),
            cell(law.reference)
        );
    }
    text
}

fn model_page(
    model: &Arc<dyn AnyModel>,
    rival: bool,
    effects: &[(Arc<dyn AnyEffect>, bool)],
    names: &[&str],
) -> Page {
    let name = model.name();
    let mut text = format!(
        "# {name}\n\n{}.\n\n```text\n{}\n```\n\n",
        capital(model.summary()),
        model.equation()
    );
    text.push_str(&parameters(model.params()));
    if let Some(slots) = Slots::of(name) {
        text.push_str(&laws("pressure", &slots.pressure));
        text.push_str(&laws("shear", &slots.shear));
    }
    let alone = Law::new(Arc::clone(model), vec![]);
    let carries = |e: &Arc<dyn AnyEffect>| {
        alone
            .as_ref()
            .is_ok_and(|law| law.with_effects([Arc::clone(e)]).is_ok())
    };
    let missing: Vec<String> = names
        .iter()
        .filter(|n| {
            let mut of_name = effects.iter().filter(|(e, _)| e.name() == **n);
            !of_name.any(|(e, _)| carries(e))
        })
        .map(|n| format!("[{n}](../effects/{n}.md)"))
        .collect();
    let _ = writeln!(
        text,
        "\n**Effects.** {}",
        if missing.is_empty() {
            "It carries all of them.".to_owned()
        } else {
            format!("It carries all but {}.", missing.join(", "))
        }
    );
    if !rival {
        text.push_str(
            "\nNo rival structure in a diagnosis: a driven wheel of it is another model's.\n",
        );
    }
    let _ = writeln!(text, "\n**Source.** {}", sentence(model.reference()));
    Page {
        file: format!("models/{name}.md"),
        text,
    }
}

fn effect_page(
    name: &str,
    forms: &[&(Arc<dyn AnyEffect>, bool)],
    models: &[(&Arc<dyn AnyModel>, bool)],
) -> Page {
    let mut text = format!("# {name}\n\n");
    for (k, (e, tried)) in forms.iter().enumerate() {
        if k == 0 {
            let scope = match e.scope() {
                Scope::Any => "on vehicles and rigs",
                Scope::Drive => "on vehicles only",
                Scope::Rig => "on rigs only",
            };
            let acts: Vec<&str> = e.touches().iter().map(|t| acts_on(*t)).collect();
            let _ = write!(
                text,
                "{}.\n\n**Where it shows.** {}; {scope}.\n\n**Isolated by.** {}\n\n**Acts on** {}.\n",
                capital(e.summary()),
                capital(e.regime()),
                sentence(&capital(e.isolated_by())),
                acts.join(", "),
            );
            let cannot: Vec<String> = models
                .iter()
                .filter(|(m, _)| Law::new(Arc::clone(m), vec![Arc::clone(e)]).is_err())
                .map(|(m, _)| format!("[{0}](../models/{0}.md)", m.name()))
                .collect();
            if !cannot.is_empty() {
                let _ = writeln!(
                    text,
                    "\nModels that cannot carry it: {}.",
                    cannot.join(", ")
                );
            }
        }
        let diagnosed = if *tried {
            "tried by a diagnosis".to_owned()
        } else if e.is_flat() {
            format!(
                "tried by a diagnosis of a drive; asked for as `{name}/{}`",
                e.form()
            )
        } else {
            format!("asked for as `{name}/{}`", e.form())
        };
        let _ = write!(
            text,
            "\n## Form `{}`\n\n{}; {diagnosed}.\n\n```text\n{}\n```\n\n{}\n**Source.** {}\n",
            e.form(),
            capital(e.summary()),
            lines(e.equation()),
            parameters(e.params()) + &follows_the_wheel(&**e),
            sentence(e.reference())
        );
    }
    Page {
        file: format!("effects/{name}.md"),
        text,
    }
}

/// What a diagnosis takes for the prior sd on another wheel than it was chosen for; empty where that is the same on all.
fn follows_the_wheel(e: &dyn AnyEffect) -> String {
    let unit = e.params().first().map_or("", |p| p.unit);
    match natural_symbol(unit).filter(|_| e.share() > 0.0) {
        None => String::new(),
        Some(symbol) => format!(
            "\nOn a wheel of load W and radius R whose {} {symbol} is more than that prior sd it is the prior sd; where it is less,\ntheir geometric mean is.\n",
            short(e.share())
        ),
    }
}

pub(super) fn acts_on(touch: Touch) -> &'static str {
    match touch {
        Touch::Contact => "the contact of wheel and soil",
        Touch::Forces => "the forces of the wheel",
        Touch::Vehicle => "the vehicle's measures",
        Touch::Loads => "loads on body and drivetrain",
        Touch::Sensor => "what a sensor reports",
    }
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

fn sentence(text: &str) -> String {
    format!("{}.", text.trim_end_matches('.'))
}
