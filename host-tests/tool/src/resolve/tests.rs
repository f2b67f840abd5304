use super::*;
use plumbline::model::catalog::find;

fn sheet(product: &str) -> Sheet {
    Sheet::of(find(product).unwrap())
}

fn names(sheet: &Sheet, name: &str) -> Result<Vec<String>, &'static str> {
    let found = entries(sheet, name).map_err(|failure| failure.code())?;
    Ok(found.into_iter().map(|entry| entry.name.clone()).collect())
}

#[test]
fn full_name_group_and_abbreviation_are_found() {
    let sheet = sheet("is2");
    assert_eq!(names(&sheet, "zero-x"), Ok(vec!["zero-x".to_owned()]));
    assert_eq!(
        names(&sheet, "Zero Offset X"),
        Ok(vec!["zero-x".to_owned()])
    );
    assert_eq!(
        names(&sheet, "bus-off"),
        Ok(vec!["bus-off-recovery".to_owned()])
    );
    let filter = vec!["cut-off".to_owned(), "filter-type".to_owned()];
    assert_eq!(names(&sheet, "filter"), Ok(filter));
    assert_eq!(names(&sheet, "cyclic"), Err("ambiguous-name"));
    assert_eq!(names(&sheet, "-"), Err("unknown-name"));
    assert_eq!(names(&sheet, ""), Err("unknown-name"));
}

#[test]
fn values_of_a_group_come_in_any_order() {
    let sheet = sheet("is2");
    for text in ["filter=2.5Hz,butterworth", "filter=butterworth,2.5Hz"] {
        let mut taken = assignments(&sheet, text).unwrap();
        taken.sort_by(|one, other| one.0.name.cmp(&other.0.name));
        let taken: Vec<(&str, &str)> = taken
            .iter()
            .map(|(entry, text)| (entry.name.as_str(), text.as_str()))
            .collect();
        assert_eq!(
            taken,
            [("cut-off", "2.5Hz"), ("filter-type", "butterworth")],
            "{text}"
        );
    }
    assert_eq!(
        assignments(&sheet, "filter=2Hz,3Hz,off")
            .unwrap_err()
            .code(),
        "bad-value"
    );
    assert_eq!(
        assignments(&sheet, "filter").unwrap_err().code(),
        "bad-assignment"
    );
}

#[test]
fn comma_between_digits_of_a_group_is_a_decimal_comma() {
    let sheet = sheet("is2");
    for (text, value) in [
        ("filter=2,5Hz,butterworth", "2,5Hz"),
        ("filter=Butterworth,1,5 Hz", "1,5 Hz"),
    ] {
        let taken = assignments(&sheet, text).unwrap();
        let found = taken.iter().find(|(entry, _)| entry.name == "cut-off");
        assert_eq!((taken.len(), &found.unwrap().1[..]), (2, value), "{text}");
    }
    // Not the filter type with the number 1 and 5 Hz.
    let taken = assignments(&sheet, "filter=1,5Hz").unwrap();
    assert_eq!((taken.len(), &taken[0].1[..]), (1, "1,5Hz"));
    assert!(assignments(&sheet, "filter=1h").is_err());
}

#[test]
fn single_value_of_a_group_sets_the_parameter_that_it_fits() {
    let sheet = sheet("is2");
    let taken = assignments(&sheet, "filter=butterworth").unwrap();
    assert_eq!(taken.len(), 1);
    assert_eq!(taken[0].0.name, "filter-type");
}
