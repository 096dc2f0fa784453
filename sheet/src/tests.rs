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

/// The line of the fault of a table.
fn fault(text: &str) -> u64 {
    let message = rows(text.as_bytes()).unwrap_err();
    message.split(':').next().unwrap().parse().unwrap()
}

/// What is read of the fields after the first of each row.
fn read<T>(text: &str, field: impl Fn(&Row, usize) -> T) -> Vec<T> {
    let mut sheet = Sheet::of(text).unwrap();
    let columns = sheet.headers.len();
    let mut fields = Vec::new();
    while let Some(row) = sheet.next_row().unwrap() {
        fields.extend((1..columns).map(|c| field(&row, c)));
    }
    fields
}

fn numbers(text: &str) -> Vec<Option<f64>> {
    read(text, |row, c| row.number(c).ok().flatten())
}

fn counts(text: &str) -> Vec<Option<f64>> {
    read(text, |row, c| row.count(c).ok().flatten())
}

#[test]
fn every_encoding_that_programs_write_is_read() {
    let text = "id,street\n1,M\u{fc}hlstra\u{df}e\n";
    let expected = vec![(2, vec!["1".to_owned(), "M\u{fc}hlstra\u{df}e".to_owned()])];
    let marked = format!("\u{feff}{text}");
    let utf16 = |unit: fn(u16) -> [u8; 2]| marked.encode_utf16().flat_map(unit).collect();
    let files: [Vec<u8>; 5] = [
        text.as_bytes().to_vec(),
        marked.as_bytes().to_vec(),
        utf16(u16::to_le_bytes),
        utf16(u16::to_be_bytes),
        b"id,street\n1,M\xfchlstra\xdfe\n".to_vec(),
    ];
    for (i, bytes) in files.iter().enumerate() {
        assert_eq!(rows(bytes).as_ref(), Ok(&expected), "file {i}");
    }
    for bytes in [&b"PK\x03\x04\x14\0"[..], b"id\n\0\x01\0\0\0", b"\xff\xfei\0\n\0\0\xdc"] {
        assert_eq!(rows(bytes).unwrap_err(), "1: not text; save it as CSV in UTF-8");
    }
    assert_eq!(fault(" {\"a\": 1}"), 1);
}

#[test]
fn the_apostrophe_before_what_begins_like_a_formula_is_no_part_of_it() {
    let text = "id,a,b\n0,'=1+1,'tis\n";
    assert_eq!(read(text, |row, c| row.text(c).to_owned()), ["=1+1", "'tis"]);
    assert_eq!(uneven::lines(text.as_bytes()).unwrap()[1].text(1), "=1+1");
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
    assert_eq!(rows(b"id;x, y;z\na;1;2\nb;3;4\n").unwrap()[0].1, ["a", "1", "2"]);
    assert_eq!(fault("id,x;y\n"), 1);
}

#[test]
fn decimal_commas_are_read_and_numbers_with_two_meanings_are_not() {
    let all = |numbers: &[f64]| numbers.iter().copied().map(Some).collect::<Vec<_>>();
    let text = "id;lat;lon\na;40,78;-111,9\nb;1,234;0\n";
    assert_eq!(numbers(text), all(&[40.78, -111.9, 1.234, 0.0]));
    assert_eq!(numbers("id,lat\na,\"40,78\"\n"), all(&[40.78]));
    // Texts and lists beside numbers show nothing.
    assert_eq!(numbers("id;x\nMain, 5th;1.5\n5,7;2\n"), all(&[1.5, 2.0]));
    assert_eq!(numbers("id,x,list\na,30.361,\"1,2\"\n"), all(&[30.361, 1.2]));
    assert_eq!(numbers("id;x;list\na;30.3612;10,7\n"), all(&[30.3612, 10.7]));
    for text in [
        "id;x\na;1,234\n", "id;x\na;1.234,5\n", "id;x\na;many\n", "id,x\na,inf\n",
        "id,x\na,\"12,345\"\n",
    ] {
        assert_eq!(numbers(text), [None], "{text}");
    }
    assert_eq!(numbers("id;x;y\na;12.345;0,5\n"), [None, Some(0.5)]);
    assert_eq!(numbers("id;x\na;40,78\nb;0.5\n"), [None, Some(0.5)]);
}

#[test]
fn a_count_with_a_point_before_three_digits_is_read_where_its_column_has_decimals() {
    assert_eq!(counts("id,x\na,12.300\nb,8150\n"), [None, Some(8150.0)]);
    assert_eq!(counts("id;lat;x\na;48,7809;12,300\n"), [Some(48.7809), None]);
    assert_eq!(counts("id,x\na,0.125\nb,12.300\n"), [Some(0.125), Some(12.3)]);
    assert_eq!(counts("id;x\na;312,457\nb;12345,6\n"), [Some(312.457), Some(12_345.6)]);
    assert_eq!(
        count("12.300").unwrap_err(),
        "12300 if the separator is one of thousands, 12.3 if decimals follow; write 12300 or 12.3000"
    );
}

#[test]
fn lines_are_those_of_the_file_whatever_ends_them() {
    let text = "# by hand\n\nid,n\n1,\"a\nb\"\n# a note, with, commas\n , \n2,5\" pipe\n\n3,y,z\n";
    for end in ["\n", "\r\n", "\r"] {
        let ended = text.replace('\n', end);
        assert_eq!(fault(&ended), 10, "{end:?}");
        assert_eq!(lines_of(&ended.replace("3,y,z", "3,y")), [4, 8, 10], "{end:?}");
    }
    for text in ["", "\n\n", "# nothing\n"] {
        let mut sheet = Sheet::of(text).unwrap();
        assert!(sheet.headers.is_empty() && sheet.next_row().unwrap().is_none(), "{text:?}");
    }
}

#[test]
fn rows_that_would_be_lost_are_refused_at_their_line() {
    // Comments that may be rows, or the names of the columns.
    assert_eq!([fault("id,n\n#12,x\n13,y\n"), fault("#id,n\n1,x\n")], [2, 1]);
    assert_eq!(rows(b"id,n\n\"#12\",x\n").unwrap()[0].1, ["#12", "x"]);
    // Quotation marks that are not closed.
    assert_eq!(fault("# a note\nid,name\n1,a\n2,\"b\n3,c\n"), 4);
    assert_eq!(fault("id,name\n1,\"Main\n2,x\n3,\"y\"\n"), 2);
    assert!(uneven::lines(b"a,b\n\n1,\"crash\n2,x\n3,y\n").is_err_and(|fault| fault.line == 3));
}
