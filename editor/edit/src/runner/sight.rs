//! How a wish is met: the value, then a picture of it, alone, over terrain, or against another value.

use std::sync::Arc;

use orograph_core::{Error, Unit, Value, ValueType};
use orograph_engine::{Compiled, Graph, Outcome, OutputRef, Request, document::Link};

use super::{Badge, Fault, News, Round, Scene, Shown, Wish, fault};
use crate::{
    beside::{Beside, grid_of, largest_difference, same_ground, unlike},
    chain::Chain,
    looks::{self, Colours, Scale},
    teller::{Work, is_look, outermost},
};

impl Round {
    pub(super) fn meet(
        &self,
        wish: &Wish,
        work: Work,
        compiled: &Compiled,
        scene: &Scene,
    ) -> Result<Shown, Vec<Fault>> {
        let output = find(compiled, &wish.output)?;
        let shown = match &wish.beside {
            Beside::Nothing => self.alone(wish, work, compiled, output, scene)?,
            Beside::Against(other) => return self.against(wish, work, compiled, (output, other), scene),
            Beside::Over(grounds) => self.over(wish, work, compiled, (output, grounds), scene)?,
        };
        let look = wish.look.as_ref().and_then(|look| self.registry.get(look));
        let scale = look.and_then(|look| looks::scale(look.spec(), &shown.value));
        Ok(Shown { scale, ..shown })
    }

    fn alone(
        &self,
        wish: &Wish,
        work: Work,
        compiled: &Compiled,
        output: OutputRef,
        scene: &Scene,
    ) -> Result<Shown, Vec<Fault>> {
        let mut chain = Chain::on(&compiled.graph, &self.registry);
        let picture = wish.look.as_ref().map(|look| chain.look(look, output, None)).transpose();
        let picture = picture.map_err(|words| about(wish, words))?;
        let graph = chain.build().map_err(|words| about(wish, words))?;
        let asked = std::iter::once(output).chain(picture).collect();
        let (values, faults) = self.values(wish, work, graph, asked, scene);
        let mut values = values.into_iter();
        let value = met(values.next(), &faults)?;
        let picture = picture.map(|_| met(values.next(), &faults)).transpose()?;
        Ok(Shown { value, picture, beside: None, ground: None, scale: None })
    }

    fn against(
        &self,
        wish: &Wish,
        work: Work,
        compiled: &Compiled,
        (output, other): (OutputRef, &Link),
        scene: &Scene,
    ) -> Result<Shown, Vec<Fault>> {
        let [first, then] = work.halves();
        let pair = [output, find(compiled, other)?];
        let (values, faults) = self.values(wish, first, compiled.graph.clone(), pair.to_vec(), scene);
        let mut values = values.into_iter();
        let (value, second) = (met(values.next(), &faults)?, met(values.next(), &faults)?);
        if let Some(fault) = unlike((&wish.output, &value), (other, &second)) {
            return Err(vec![fault]);
        }
        let largest = largest_difference(&value, &second);
        let shares = value.value_type() == ValueType::Mask;
        let mut chain = Chain::on(&compiled.graph, &self.registry);
        let picture = chain.difference(pair, shares, largest).map_err(|words| about(wish, words))?;
        let graph = chain.build().map_err(|words| about(wish, words))?;
        let (values, faults) = self.values(wish, then, graph, vec![picture], scene);
        let picture = Some(met(values.into_iter().next(), &faults)?);
        let unit = if shares { Unit::One } else { Unit::Metre };
        let scale = Some(Scale { colours: Colours::Diverging, low: -largest, high: largest, unit });
        Ok(Shown { value, picture, beside: Some(second), ground: None, scale })
    }

    fn over(
        &self,
        wish: &Wish,
        work: Work,
        compiled: &Compiled,
        (output, grounds): (OutputRef, &[Link]),
        scene: &Scene,
    ) -> Result<Shown, Vec<Fault>> {
        let [first, then] = work.halves();
        // Terrain that cannot be had is none to draw upon, and no fault of what is drawn.
        let grounds: Vec<_> = grounds.iter().filter_map(|link| find(compiled, link).ok()).collect();
        let asked = std::iter::once(output).chain(grounds.iter().copied()).collect();
        let (values, faults) = self.values(wish, first, compiled.graph.clone(), asked, scene);
        let mut values = values.into_iter();
        let value = met(values.next(), &faults)?;
        let lies = |ground: &Value| match (grid_of(&value), ground) {
            (Some(grid), Value::Heightfield(terrain)) => same_ground(grid, terrain.grid()),
            _ => false,
        };
        let found =
            grounds.into_iter().zip(values).find_map(|(output, ground)| Some((output, ground.filter(lies)?)));
        let (ground, beside) = found.unzip();
        let Some(look) = &wish.look else {
            return Ok(Shown { value, picture: None, beside, ground: None, scale: None });
        };
        let mut chain = Chain::on(&compiled.graph, &self.registry);
        let spec = self.registry.get(look).map(|look| look.spec());
        let draws_over = spec.is_some_and(|spec| looks::ground_port(spec).is_some());
        let shade = looks::of(&self.registry, ValueType::Heightfield).into_iter().next();
        let under = match (ground, shade) {
            (Some(ground), Some(shade)) if draws_over => Some(chain.look(&shade.id, ground, None)),
            _ => None,
        };
        let under = under.transpose().map_err(|words| about(wish, words))?;
        let picture = chain.look(look, output, under).map_err(|words| about(wish, words))?;
        let graph = chain.build().map_err(|words| about(wish, words))?;
        let asked = std::iter::once(picture).chain(under).collect();
        let (values, faults) = self.values(wish, then, graph, asked, scene);
        let mut values = values.into_iter();
        let picture = Some(met(values.next(), &faults)?);
        Ok(Shown { value, picture, beside, ground: values.next().flatten(), scale: None })
    }

    /// Evaluates outputs, tells how the nodes stand that give them, and what went wrong.
    fn values(
        &self,
        wish: &Wish,
        work: Work,
        graph: Graph,
        outputs: Vec<OutputRef>,
        scene: &Scene,
    ) -> (Vec<Option<Value>>, Vec<Fault>) {
        let mut request = Request::values(Arc::new(graph), outputs);
        request.context = scene.context;
        let report = self.evaluator.run(request, self.teller(work), &self.token);
        for node in &report.nodes {
            let done = match &node.outcome {
                Outcome::Failed(_) | Outcome::Skipped { .. } => continue,
                outcome => Badge::Done {
                    how: outcome.word(),
                    micros: node.micros,
                    bytes: node.bytes,
                    warnings: node.warnings.clone(),
                },
            };
            if !is_look(&node.name) {
                self.tell(News::Node(outermost(&node.name).to_owned(), done));
            }
        }
        let failures = report.failures().filter(|(_, error)| **error != Error::Cancelled);
        let mut failures: Vec<_> = failures
            .map(|(node, error)| Fault {
                node: Some(if is_look(&node.name) {
                    wish.output.node.clone()
                } else {
                    outermost(&node.name).to_owned()
                }),
                message: error.to_string(),
                help: error.hint(),
            })
            .collect();
        if failures.is_empty() && report.values.iter().any(Option::is_none) {
            failures = about(wish, "cancelled".into());
        }
        (report.values, failures)
    }
}

fn find(compiled: &Compiled, link: &Link) -> Result<OutputRef, Vec<Fault>> {
    let output = compiled.output(&link.to_string()).map_err(|error| vec![fault(&error)])?;
    match compiled.missing.get(&output.node) {
        Some(error) => Err(vec![fault(error)]),
        None => Ok(output),
    }
}

fn about(wish: &Wish, message: String) -> Vec<Fault> {
    vec![Fault { node: Some(wish.output.node.clone()), message, help: None }]
}

/// A value that was asked for, or why it is not there.
fn met(value: Option<Option<Value>>, faults: &[Fault]) -> Result<Value, Vec<Fault>> {
    value.flatten().ok_or_else(|| faults.to_vec())
}
