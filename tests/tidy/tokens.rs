//! Paths in tokens that have no syntax of their own: arguments of macros and of attributes.

use proc_macro2::{Delimiter, Span, TokenStream, TokenTree};

/// A path within tokens.
pub(crate) struct Found {
    pub(crate) path: Vec<String>,
    pub(crate) span: Span,
    /// Whether arguments follow.
    pub(crate) called: bool,
}

/// Returns the paths within tokens, those in groups included. A name alone counts if it looks like an item:
/// capital letters or arguments that follow, and no dot before.
pub(crate) fn paths(tokens: TokenStream) -> Vec<Found> {
    let mut found = Vec::new();
    scan(tokens, &mut found);
    found
}

/// Returns the names of the types that tokens declare: a macro may make items of them.
pub(crate) fn types(tokens: TokenStream) -> Vec<String> {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let mut found = Vec::new();
    for (at, token) in tokens.iter().enumerate() {
        match (token, tokens.get(at + 1)) {
            (TokenTree::Group(group), _) => found.extend(types(group.stream())),
            (TokenTree::Ident(word), Some(TokenTree::Ident(name)))
                if ["struct", "enum", "trait"].iter().any(|w| word == w) =>
            {
                found.push(name.to_string());
            }
            _ => {}
        }
    }
    found
}

fn is(token: Option<&TokenTree>, sign: char) -> bool {
    matches!(token, Some(TokenTree::Punct(p)) if p.as_char() == sign)
}

fn scan(tokens: TokenStream, found: &mut Vec<Found>) {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let mut at = 0;
    while at < tokens.len() {
        match &tokens[at] {
            TokenTree::Group(group) => scan(group.stream(), found),
            TokenTree::Ident(first) => {
                let field = at > 0
                    && is(tokens.get(at - 1), '.')
                    && !(at > 1 && is(tokens.get(at - 2), '.'));
                let (mut path, span) = (vec![first.to_string()], first.span());
                while is(tokens.get(at + 1), ':') && is(tokens.get(at + 2), ':') {
                    let Some(TokenTree::Ident(next)) = tokens.get(at + 3) else { break };
                    path.push(next.to_string());
                    at += 3;
                }
                let called = match tokens.get(at + 1) {
                    Some(TokenTree::Group(g)) => g.delimiter() == Delimiter::Parenthesis,
                    next => is(next, '!'),
                };
                let capital = path[0].starts_with(char::is_uppercase);
                if !field && (path.len() > 1 || called || capital) {
                    found.push(Found { path, span, called });
                }
            }
            _ => {}
        }
        at += 1;
    }
}
