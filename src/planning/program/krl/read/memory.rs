//! The variables of a program.

use std::collections::{BTreeMap, BTreeSet};

use super::statement::{Aggregate, Declaration, Place, Value};

/// Variables of the control itself that a program may fill. What stands in them before is not known.
const OF_THE_CONTROL: [&str; 5] = ["TOOL_DATA", "BASE_DATA", "FDAT_ACT", "LDAT_ACT", "PDAT_ACT"];

/// The scope of variables that all files see. No module has an empty name.
const EVERYWHERE: &str = "";

/// The data list of the control itself. All files see what it declares.
const CONFIG: &str = "$CONFIG";

/// The values of all variables that the text gives.
#[derive(Default)]
pub(super) struct Memory {
    /// Scope and name.
    declared: BTreeSet<(String, String)>,
    /// Scope, name and index.
    values: BTreeMap<(String, String, Option<i64>), Value>,
}

impl Memory {
    /// Makes the variables of a declaration in a module anew. Without a value of their own they have none.
    pub(super) fn declare(&mut self, module: &str, declaration: &Declaration) {
        let scope = if declaration.global || module == CONFIG { EVERYWHERE } else { module };
        for (place, value) in &declaration.variables {
            self.declared.insert((scope.to_owned(), place.name.clone()));
            let key = (scope.to_owned(), place.name.clone(), place.index);
            match value {
                Some(value) => self.values.insert(key, value.value.clone()),
                None => self.values.remove(&key),
            };
        }
    }

    /// Whether a variable exists for a module.
    pub(super) fn knows(&self, module: &str, name: &str) -> bool {
        self.scope(module, name).is_some()
    }

    /// What stands in a variable.
    ///
    /// # Errors
    /// In words, that it does not stand in the text.
    pub(super) fn get(&self, module: &str, place: &Place) -> Result<&Value, String> {
        let value = self
            .scope(module, &place.name)
            .and_then(|scope| self.values.get(&(scope.to_owned(), place.name.clone(), place.index)));
        let value = match (value, &place.field) {
            (Some(Value::Aggregate(aggregate)), Some(field)) => component(aggregate, field),
            (Some(_), Some(_)) => None,
            (value, None) => value,
            (None, _) => None,
        };
        value.ok_or_else(|| format!("what {} is does not stand in the files of this program", said(place)))
    }

    /// Sets a variable. Of a structure only the components that are given change, as the control does it.
    ///
    /// # Errors
    /// In words, that there is no such variable.
    pub(super) fn set(&mut self, module: &str, place: &Place, value: Value) -> Result<(), String> {
        let missing = || format!("{} is declared in none of the files of this program", said(place));
        let scope = self.scope(module, &place.name).ok_or_else(missing)?;
        let key = (scope.to_owned(), place.name.clone(), place.index);
        match (self.values.get_mut(&key), &place.field, value) {
            (Some(Value::Aggregate(old)), Some(field), value) => overwrite(old, field, value),
            (_, Some(_), _) => return Err(missing()),
            (Some(Value::Aggregate(old)), None, Value::Aggregate(new)) => {
                for (name, value) in new.components {
                    overwrite(old, &name.value, value.value);
                }
            }
            (_, None, value) => {
                self.values.insert(key, value);
            }
        }
        Ok(())
    }

    fn scope<'a>(&self, module: &'a str, name: &str) -> Option<&'a str> {
        let declared = |scope: &str| self.declared.contains(&(scope.to_owned(), name.to_owned()));
        if declared(module) {
            return Some(module);
        }
        (declared(EVERYWHERE) || OF_THE_CONTROL.contains(&name)).then_some(EVERYWHERE)
    }
}

/// A component of a structure.
pub(super) fn component<'a>(aggregate: &'a Aggregate, name: &str) -> Option<&'a Value> {
    let found = aggregate.components.iter().find(|(component, _)| component.value == name);
    found.map(|(_, value)| &value.value)
}

fn overwrite(aggregate: &mut Aggregate, name: &str, value: Value) {
    use super::statement::At;
    match aggregate.components.iter_mut().find(|(component, _)| component.value == name) {
        Some((_, old)) => old.value = value,
        None => {
            let name = At { column: 1, value: name.to_owned() };
            aggregate.components.push((name, At { column: 1, value }));
        }
    }
}

/// A variable as it stands in a program.
pub(super) fn said(place: &Place) -> String {
    let index = place.index.map_or_else(String::new, |index| format!("[{index}]"));
    let field = place.field.as_ref().map_or_else(String::new, |field| format!(".{field}"));
    format!("{}{index}{field}", place.name)
}
