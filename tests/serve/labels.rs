//! Pages show labels, in any script, instead of the names in the spec.

use std::collections::BTreeMap;

use hierarq::serve::{Options, Server};
use serde_json::Value as Json;

use super::Running;
use super::client::may;

fn labelled(pairs: &[(&str, &str)]) -> BTreeMap<String, String> {
    pairs.iter().map(|(name, text)| ((*name).to_string(), (*text).to_string())).collect()
}

/// Returns the visible text of a state, without identifiers for the program.
fn read(state: &Json) -> String {
    state.to_string()
}

#[test]
fn pages_of_a_schedule_show_labels() {
    let mut mission = super::mission();
    let ben = "<b>ben</b>";
    let all =
        [("anna", "Łukasz"), (ben, "<i>Ann-Marie</i>"), ("m1", "Wózek 1"), ("m2", "Wózek 2"), ("carrier", "葡萄车")];
    mission.problem.labels.members = labelled(&all);
    let on = Running {
        server: Some(
            Server::start("field", &mission, &Options { speed: 40.0, begin: true, ..Options::default() })
                .expect("a server"),
        ),
    };
    let link = on.link(Some("Łukasz"));
    let looked = on.stranger().get(&link);
    assert!(looked.body.contains("Łukasz") && !looked.body.contains("anna"), "{}", looked.body);
    let markup = on.stranger().get(&on.link(Some("<i>Ann-Marie</i>"))).body;
    assert!(markup.contains("&lt;i&gt;Ann-Marie") && !markup.contains("<i>Ann-Marie"), "{markup}");
    let (person, supervisor) = (on.open(Some("Łukasz")), on.supervisor());
    person.until(may("begin"));
    person.press("begin", 0);
    person.press("done", 0);
    person.until(|state| read(&state["person"]["messages"]).contains("Wózek"));
    let state = person.state();
    assert_eq!(state["person"]["name"], "Łukasz");
    let (own, whole) = (read(&state["person"]), read(&supervisor.state()));
    for name in ["\"anna\"", "m1", "m2", ben, "carrier"] {
        assert!(!own.contains(name) && !whole.contains(name), "{name}: {own}\n{whole}");
    }
    for label in ["Łukasz", "Wózek 1", "葡萄车"] {
        assert!(whole.contains(label), "{label}: {whole}");
    }
    for picture in ["/supervisor/gantt.svg", "/supervisor/map.svg"] {
        let svg = supervisor.get(picture).body;
        assert!(svg.contains("Łukasz") && svg.contains("Wózek 2") && !svg.contains("anna"), "{picture}: {svg}");
        assert!(roxmltree::Document::parse(&svg).is_ok());
    }
}

#[test]
fn pages_of_layers_show_labels() {
    let mut mission = super::layers::mission();
    mission.problem.labels.members = labelled(&[("<b>anna</b>", "Łukasz"), ("left", "Ramię lewe"), ("box", "Pudełko")]);
    mission.problem.labels.tasks = labelled(&[("lid", "Pokrywa")]);
    mission.problem.labels.layers = labelled(&[("opened", "Otwarcie")]);
    let on = Running {
        server: Some(
            Server::start("field", &mission, &Options { speed: 20.0, begin: true, ..Options::default() })
                .expect("a server"),
        ),
    };
    let (person, supervisor) = (on.open(Some("Łukasz")), on.supervisor());
    let state = person.until(may("begin"));
    assert_eq!(state["person"]["doing"], "Your turn: Pokrywa: open, to Pudełko.");
    assert_eq!(
        (&state["person"]["name"], &state["person"]["groups"][0]["heading"]),
        (&"Łukasz".into(), &"Pokrywa".into())
    );
    assert!(person.press_task("begin", 0).said().starts_with("Noted: Pokrywa began at"));
    person.press_task("done", 0);
    person.until(|state| read(&state["person"]["messages"]).contains("Layer Otwarcie is done."));
    let whole = read(&supervisor.state());
    assert!(whole.contains("Ramię lewe") && whole.contains("Łukasz") && !whole.contains("<b>anna"), "{whole}");
}
