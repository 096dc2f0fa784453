//! OpenStreetMap XML in the mirror, by its text: nothing here uses the code that is tested.

/// Returns a file with east and west exchanged, as somebody would map the mirrored town.
pub(crate) fn mirrored(xml: &str) -> String {
    let mut text = String::with_capacity(xml.len());
    let mut rest = xml;
    while let Some(start) = rest.find('<') {
        let Some(length) = element_length(&rest[start..]) else { break };
        let element = &rest[start..start + length];
        text.push_str(&rest[..start]);
        text.push_str(&mirrored_element(element));
        rest = &rest[start + length..];
    }
    text + rest
}

fn element_length(text: &str) -> Option<usize> {
    let end = if text.starts_with("<!--") { "-->" } else { ">" };
    text.find(end).map(|at| at + end.len())
}

fn mirrored_element(element: &str) -> String {
    if element.starts_with("<node") {
        let longitude = attribute(element, "lon");
        let mirrored = match longitude.strip_prefix('-') {
            Some(positive) => positive.to_owned(),
            None => format!("-{longitude}"),
        };
        return with_attribute(element, "lon", &mirrored);
    }
    if element.starts_with("<tag") {
        let (key, value) = (attribute(element, "k"), attribute(element, "v"));
        let by_lane = key.split(':').any(|part| part == "lanes") && value.contains('|');
        let value = if by_lane {
            value.split('|').rev().collect::<Vec<_>>().join("|")
        } else {
            value.to_owned()
        };
        if key.starts_with("turn:lanes") || key.starts_with("restriction") {
            return with_attribute(element, "v", &exchanged(&value));
        }
        return with_attribute(element, "v", &value);
    }
    element.to_owned()
}

fn exchanged(text: &str) -> String {
    text.replace("left", "\u{1}").replace("right", "left").replace('\u{1}', "right")
}

fn span(element: &str, name: &str) -> (usize, usize) {
    let key = format!(" {name}=");
    let at = element.find(&key).unwrap_or_else(|| panic!("{element} without {name}")) + key.len();
    let quote = element.as_bytes()[at] as char;
    let length = element[at + 1..].find(quote).expect("a closing quote");
    (at + 1, at + 1 + length)
}

fn attribute<'a>(element: &'a str, name: &str) -> &'a str {
    let (start, end) = span(element, name);
    &element[start..end]
}

fn with_attribute(element: &str, name: &str, value: &str) -> String {
    let (start, end) = span(element, name);
    format!("{}{value}{}", &element[..start], &element[end..])
}
