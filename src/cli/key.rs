//! `bladeplan key`: makes, lists and revokes the keys of a service. It works on the database file, beside a
//! running service or without one.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Subcommand};

use super::job::say;
use crate::clock;
use crate::http::auth::hash_of;
use crate::job::id::KeyId;
use crate::job::role::Role;
use crate::store::keys::Key;
use crate::store::{Error, Store};

/// The arguments of `bladeplan key`.
#[derive(Debug, Args)]
pub struct Arguments {
    #[command(subcommand)]
    what: What,

    /// The database file of the service
    #[arg(long, value_name = "FILE", default_value = "./bladeplan.db", global = true)]
    database: PathBuf,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Make a key and print it, once; from the first key on, every request needs one
    Create {
        /// What it may be used for
        #[arg(long, value_enum)]
        role: Role,
        /// Whose it is; audit rows carry this name
        #[arg(long)]
        name: String,
        /// The machine that it belongs to; for the role machine
        #[arg(long)]
        machine: Option<String>,
    },
    /// List the keys, without their secrets
    List,
    /// Take a key back for good
    Revoke {
        /// Its name
        name: String,
    },
}

/// The longest name of a key, in characters.
const LONGEST_NAME: usize = 64;

/// The person at the console who may write the database file needs no key.
const ACTOR: &str = "console";

/// Does what is asked for.
#[must_use]
pub fn run(arguments: Arguments) -> ExitCode {
    let runtime = match tokio::runtime::Builder::new_current_thread().enable_all().build() {
        Ok(runtime) => runtime,
        Err(error) => return fail(&error.to_string()),
    };
    match runtime.block_on(act(arguments)) {
        Ok(words) => {
            say(words);
            ExitCode::SUCCESS
        }
        Err(words) => fail(&words),
    }
}

fn fail(words: &str) -> ExitCode {
    eprintln!("bladeplan: {words}");
    ExitCode::FAILURE
}

async fn act(arguments: Arguments) -> Result<String, String> {
    let store = Store::open(&arguments.database).await.map_err(|error| error.to_string())?;
    let words = match arguments.what {
        What::Create { role, name, machine } => create(&store, role, name, machine).await,
        What::List => list(&store).await,
        What::Revoke { name } => revoke(&store, &name).await,
    };
    store.close().await;
    words
}

async fn create(store: &Store, role: Role, name: String, machine: Option<String>) -> Result<String, String> {
    let fits = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.' | '@');
    if name.is_empty() || name.len() > LONGEST_NAME || !name.chars().all(fits) {
        return Err(format!("a name has 1 to {LONGEST_NAME} letters, digits, '-', '_', '.' or '@'"));
    }
    if (role == Role::Machine) != machine.is_some() {
        return Err("--machine goes with --role machine, and only with it".to_owned());
    }
    let now = clock::now();
    let id = KeyId::new(now, &clock::entropy());
    let secret = clock::secret();
    let words = format!("{id}.{secret}");
    let key = Key { id, name, role, machine, hash: hash_of(&secret), created_at: now, revoked_at: None };
    store.add_key(&key, ACTOR).await.map_err(|error| match error {
        Error::Exists => format!("there is a key named {} already; revoked ones keep their names", key.name),
        other => other.to_string(),
    })?;
    eprintln!("This is shown once. Send it as: Authorization: Bearer KEY");
    Ok(words)
}

async fn list(store: &Store) -> Result<String, String> {
    let keys = store.keys().await.map_err(|error| error.to_string())?;
    let line = |key: &Key| {
        let machine = key.machine.as_deref().map_or(String::new(), |machine| format!(" {machine}"));
        let revoked = key.revoked_at.map_or(String::new(), |at| format!(" revoked {at}"));
        format!("{} {} {}{machine} made {}{revoked}", key.id, key.name, key.role.word(), key.created_at)
    };
    Ok(keys.iter().map(line).collect::<Vec<_>>().join("\n"))
}

async fn revoke(store: &Store, name: &str) -> Result<String, String> {
    match store.revoke_key(name, ACTOR, clock::now()).await {
        Ok(()) => Ok(format!("the key of {name} is not taken any more")),
        Err(Error::NotFound) => Err(format!("there is no key named {name} that still holds")),
        Err(other) => Err(other.to_string()),
    }
}
