//! What is read, what is refused, and on which line.

use super::*;

/// Lines and fields of a table, or its fault.
fn rows(bytes: &[u8]) -> Result<Vec<(u64, Vec<String>)>, String> {
    let read = || {
        let mut sheet = Sheet::open(bytes)?;
        let mut rows = Vec::new();
        while let Some(row) = sheet.next_row()? {
            rows.push((row.line, row.fields.iter().map(str::to_owned).collect()));
        }
        Ok(rows)
    };
    read().map_err(|Fault { line, message }| format!("{line}: {message}"))
}

fn lines_of(text: &str) -> Vec<u64> {
    rows(text.as_bytes()).unwrap().iter().map(|r| r.0).collect()
}

fn error(text: &str) -> String {
    rows(text.as_bytes()).unwrap_err()
}

/// The numbers of the columns after the first.
fn numbers(text: &str) -> Vec<Result<Option<f64>, &'static str>> {
    let mut sheet = Sheet::of(text).unwrap();
    let columns = sheet.headers().len();
    let mut numbers = Vec::new();
    while let Some(row) = sheet.next_row().unwrap() {
        numbers.extend((1..columns).map(|c| row.number(c)));
    }
    numbers
}

fn utf16(text: &str, unit: fn(u16) -> [u8; 2]) -> Vec<u8> {
    text.encode_utf16().flat_map(unit).collect()
}

#[test]
fn every_encoding_of_unicode_is_read_with_or_without_a_mark() {
    let text = "id,street\n1,M\u{fc}hlstra\u{df}e\n";
    let expected = vec![(2, vec!["1".to_owned(), "M\u{fc}hlstra\u{df}e".to_owned()])];
    let marked = format!("\u{feff}{text}");
    let files = [
        text.as_bytes().to_vec(),
        marked.as_bytes().to_vec(),
        utf16(&marked, u16::to_le_bytes),
        utf16(&marked, u16::to_be_bytes),
        utf16(text, u16::to_le_bytes),
        utf16(text, u16::to_be_bytes),
    ];
    for (i, bytes) in files.iter().enumerate() {
        assert_eq!(rows(bytes).as_ref(), Ok(&expected), "file {i}");
    }
}

#[test]
fn the_apostrophe_before_what_begins_like_a_formula_is_no_part_of_it() {
    let text = "id,street\n'=1+1,'tis\n'-5th,'5th\n";
    let mut sheet = Sheet::of(text).unwrap();
    let row = sheet.next_row().unwrap().unwrap();
    assert_eq!((row.text(0), row.text(1)), ("=1+1", "'tis"));
    let row = sheet.next_row().unwrap().unwrap();
    assert_eq!((row.text(0), row.text(1)), ("-5th", "'5th"));
    assert_eq!(uneven::lines(text.as_bytes()).unwrap()[1].text(0), "=1+1");
}

#[test]
fn what_is_no_text_is_named() {
    let error = |bytes: &[u8]| rows(bytes).unwrap_err();
    assert!(
        error(b"id,n\n1,caf\xe9\n")
            .starts_with("2: not UTF-8 text but probably Windows-1252 or Latin-1 (byte E9); save")
    );
    assert!(error(b"PK\x03\x04\x14").starts_with("1: a ZIP archive or a workbook such as .xlsx"));
    assert!(error(b"\xd0\xcf\x11\xe0\xa1").starts_with("1: an Excel workbook"));
    assert!(error(b"id\n\0\x01\0\0\0").starts_with("2: binary data"));
    assert!(error(b"\xff\xfei\0d\0\n\0x").starts_with("2: UTF-16 text that ends within a letter"));
    assert!(error(b"\xff\xfei\0\n\0\0\xdc").starts_with("2: broken UTF-16 text"));
    assert!(error(b" {\"a\": 1}").starts_with("1: holds JSON or XML"));
}

#[test]
fn columns_may_be_separated_by_semicolons_tabs_and_bars() {
    let expected = vec![(2, vec!["a".to_owned(), "1".to_owned(), "2".to_owned()])];
    for separator in [",", ";", "\t", "|"] {
        let text = "id,x,y\na,1,2\n".replace(',', separator);
        assert_eq!(rows(text.as_bytes()).as_ref(), Ok(&expected), "{separator:?}");
    }
    assert_eq!(lines_of("sep=;\r\nid;x\r\na;1\r\n"), [3]);
    // The separator of a single column of Excel's.
    assert_eq!(lines_of("\"sep=;\"\nid\na\n"), [3]);
}

#[test]
fn the_rows_decide_where_the_names_hold_two_separators() {
    assert_eq!(rows(b"id,x;y,z\na,1,2\n").unwrap()[0].1, ["a", "1", "2"]);
    assert_eq!(rows(b"id;x, y;z\na;1;2\nb;3;4\n").unwrap()[0].1, ["a", "1", "2"]);
    assert_eq!(
        error("id,x;y\n"),
        "1: the columns may be separated by commas or by semicolons; put texts that contain one \
         of them in quotes"
    );
}

#[test]
fn decimal_commas_are_read_where_they_can_be_nothing_else() {
    assert_eq!(
        numbers("id;lat;lon\na;40,78;-111,9\nb;1,234;0\n"),
        [Ok(Some(40.78)), Ok(Some(-111.9)), Ok(Some(1.234)), Ok(Some(0.0))]
    );
    assert_eq!(numbers("id,lat\na,\"40,78\"\nb,\n"), [Ok(Some(40.78)), Ok(None)]);
    // Texts with commas are no numbers and show nothing.
    assert_eq!(numbers("id;x\nMain, 5th;1.5\n5,7;2\n"), [Ok(Some(1.5)), Ok(Some(2.0))]);
}

#[test]
fn a_number_with_two_meanings_is_refused() {
    let refused = |text: &str| {
        let first = numbers(text).into_iter().find_map(Result::err);
        first.expect("one of them is refused")
    };
    let separators = "write numbers with a point and without thousands separators";
    assert_eq!(refused("id;x\na;1,234\n"), separators);
    assert_eq!(refused("id;x\na;1.234,5\n"), separators);
    assert_eq!(refused("id;x;y\na;12.345;0,5\n"), separators);
    assert_eq!(refused("id,x,y\na,\"12,345\",0.5\n"), separators);
    assert!(refused("id;x;y\na;40,78;0.5\n").contains("others a decimal comma"));
    assert_eq!(refused("id;x\na;many\n"), "write a number such as 40.78");
    assert_eq!(refused("id,x\na,inf\n"), "write a number such as 40.78");
}

/// The numbers of what is many in the columns after the first.
fn counts_of(text: &str) -> Vec<Result<Option<f64>, String>> {
    let mut sheet = Sheet::of(text).unwrap();
    let columns = sheet.headers().len();
    let mut counts = Vec::new();
    while let Some(row) = sheet.next_row().unwrap() {
        counts.extend((1..columns).map(|c| row.count(c)));
    }
    counts
}

#[test]
fn a_count_with_a_point_before_three_digits_is_refused_with_both_meanings() {
    let refused = |text: &str| counts_of(text).into_iter().find_map(Result::err).unwrap();
    let both = "12300 if the point separates thousands, 12.3 if it separates decimals; write 12300 or 12.3";
    assert_eq!(refused("id,x\na,12.300\nb,8150\n"), both);
    assert_eq!(refused("id;lat;x\na;48.7809;12.300\nb;48.78;8.150\n"), both);
    assert!(refused("id,x\na,1.234\n").ends_with("; write 1234 or 1.2340"));
    assert!(refused("id,x\na,1.000\n").ends_with("; write 1000 or 1"));
    assert_eq!(
        refused("id;lat;x\na;48,7809;12,300\n"),
        "12300 if the comma separates thousands, 12.3 if it separates decimals; write 12300 or 12,3"
    );
}

#[test]
fn decimals_of_counts_are_read_where_the_column_shows_that_it_has_some() {
    let read = |text: &str| counts_of(text).into_iter().map(|n| n.unwrap().unwrap()).collect();
    let counts: Vec<f64> = read("id,x\na,312.457\nb,12345.678\n");
    assert_eq!(counts, [312.457, 12_345.678]);
    let counts: Vec<f64> = read("id,x\na,0.125\nb,12.5\nc,8150\nd,1.250\n");
    assert_eq!(counts, [0.125, 12.5, 8150.0, 1.25]);
    let counts: Vec<f64> = read("id;x;y\na;312,457;1\nb;12345,6;2\n");
    assert_eq!(counts, [312.457, 1.0, 12_345.6, 2.0]);
    // Lengths and coordinates are no counts.
    let lengths = numbers("id,length_m,lon\na,45.250,-111.900\n");
    assert_eq!(lengths, [Ok(Some(45.25)), Ok(Some(-111.9))]);
    assert_eq!(count("12.300", ["8150", "7.25"].into_iter().any(has_decimals)), Ok(12.3));
    assert!(count("12.300", ["8150", "8.150"].into_iter().any(has_decimals)).is_err());
    assert!(count("12,300", false).is_err_and(|e| e.contains("thousands separators")));
}

#[test]
fn lines_are_those_of_the_file() {
    assert_eq!(lines_of("id,n\n\n1,\"a\nb\"\n , \r\n\r\n2,x\n"), [3, 7]);
    assert_eq!(lines_of("# by hand\n\n# on Monday\nid,n\n# first\n1,x\n#\n2,y\n# end"), [6, 8]);
    assert_eq!(lines_of("id,n\r1,x\r2,y"), [2, 3]);
    assert_eq!(
        error("# a note\n\nid,n\n# more\n1\n"),
        "5: 1 fields, but 2 columns; complete or remove it"
    );
}

#[test]
fn lines_are_the_same_whatever_ends_them() {
    let text = "# by hand\n\nsep,n\n1,\"a\nb\"\n# a note, with, commas\n , \n2,x\n\n3,y,z\n";
    let expected = "10: 3 fields, but 2 columns; write numbers with a point (40.78, not 40,78) and put texts with \
                    commas in quotes";
    for end in ["\n", "\r\n", "\r"] {
        let ended = text.replace('\n', end);
        assert_eq!(error(&ended), expected, "{end:?}");
        assert_eq!(lines_of(&ended.replace("3,y,z", "3,y")), [4, 8, 10], "{end:?}");
        let said = "sep=;\nid;x\na;1\n".replace('\n', end);
        assert_eq!(lines_of(&said), [3], "{end:?}");
        let latin: Vec<u8> = [ended.as_bytes(), b"caf\xe9,1\n"].concat();
        assert!(rows(&latin).unwrap_err().starts_with("11: not UTF-8"), "{end:?}");
    }
    assert_eq!(lines_of("id,n\r# k\r1,x\r"), [3], "no comment hides the rows behind it");
}

#[test]
fn a_comment_that_may_be_a_row_is_refused() {
    let expected = |line: u64| format!("{line}: starts with # as a comment does, but has as many");
    assert!(error("id,n\n#12,x\n13,y\n").starts_with(&expected(2)));
    assert!(error("#id,n\n1,x\n").starts_with(&expected(1)));
    assert!(error("id,n\n1,x\n\n# one, two\n").starts_with(&expected(4)));
    assert_eq!(rows(b"id,n\n\"#12\",x\n").unwrap()[0].1, ["#12", "x"]);
}

#[test]
fn a_row_of_another_length_says_what_to_do() {
    assert!(
        error("lat,lon\n40,78,-111,9\n")
            .contains("2: 4 fields, but 2 columns; write numbers with a point")
    );
    assert!(error("a;b\n1;2;3\n").contains("2: 3 fields, but 2 columns; put texts"));
}

#[test]
fn a_file_without_text_has_no_columns() {
    for text in ["", "\n\n", "# nothing\n"] {
        let mut sheet = Sheet::of(text).unwrap();
        assert!(sheet.headers().iter().all(str::is_empty), "{text:?}");
        assert!(sheet.next_row().unwrap().is_none());
    }
}

#[test]
fn a_quotation_mark_that_is_not_closed_is_refused_at_its_line() {
    let why = "2: a quotation mark is not closed; close or remove it";
    assert_eq!(error("id,name\n1,\"Main\n2,x\n3,y\n"), why);
    assert_eq!(error("id,name\n1,\"Main\n2,x\n3,\"y\"\n"), why);
    let later = error("# a note\nid,name\n1,a\n2,\"b\n3,c\n");
    assert_eq!(later, "4: a quotation mark is not closed; close or remove it");
    assert_eq!(lines_of("id,name\n1,\"Main\nStreet\"\n2,5\" pipe\n"), [2, 4]);
}
