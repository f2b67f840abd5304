//! The FSC sensors match the tables of their products, from which descriptors are generated, and the ordering information.

use crate::tester::fsc::*;
use plumbline::application::Application;
use plumbline::fsc::table::{Operation, Source};
use plumbline::fsc::{Article, Product};
use plumbline::model::catalog;
use plumbline::model::gemac::is1::{self, OneAxis};
use plumbline::model::gemac::is2::{self, TwoAxes};
use plumbline::node::Action;
use plumbline::param::Table;

type TableOf<P> = <<P as Product>::Application as Application>::Table;

fn check_tables<P: Product>(article: &'static Article) {
    let parameters = TableOf::<P>::PARAMETERS;
    let quantities = <P::Application as Application>::QUANTITIES;
    let size = |source: Source| usize::from(source.data_type(parameters, quantities).size());
    let mut tester: FscTester<P> = online(article);
    tester.ask(&[0x26, 1]); // with the counter in 00h
    for function in P::FUNCTIONS {
        let name = function.name;
        let expected = 2 + function
            .reply
            .iter()
            .map(|field| size(field.source))
            .sum::<usize>();
        if function.signature.is_empty() || function.operation == Operation::Alive {
            assert_eq!(tester.ask(&[function.code]).len(), expected, "{name}");
        } else {
            let reply = tester.ask(&request(function.code, function.signature));
            assert_eq!(reply.len(), expected, "{name}");
            assert_eq!(reply[1] & CMD_PARAM_ERROR, 0, "{name}");
        }
    }
    for access in P::ACCESS {
        let reply = tester.ask(&[access.read]);
        let factory = access.parameters.iter().flat_map(|id| {
            let bytes = parameters[usize::from(id.0)].factory.to_le_bytes();
            bytes.into_iter().take(size(Source::Parameter(*id)))
        });
        assert_eq!(reply[2..], factory.collect::<Vec<u8>>(), "{}", access.name);
        let written = tester.ask(&request(access.write, &reply[2..]));
        assert_eq!(written[1] & CMD_PARAM_ERROR, 0, "{}", access.name);
    }
    tester.silent(b"\xFFRESET");
    assert!(tester.actions.contains(&Action::Restart));
}

#[test]
fn replies_match_all_rows_of_tables() {
    check_tables::<OneAxis>(&is1::BP_CL);
    check_tables::<TwoAxes>(&is2::BP_CL);
}

#[test]
fn article_numbers_match_table_26() {
    let articles = |product: &str| -> Vec<_> {
        let product = catalog::find(product).unwrap();
        let pair = |article: catalog::Article| (article.name, article.number);
        product.articles().map(pair).collect()
    };
    assert_eq!(
        articles("is1"),
        [
            ("IS1BP360-C-CL", "PR-23050-30"),
            ("IS1MA360-C-BL", "PR-25000-00"),
            ("IS1BP360-C-BL", "PR-25050-30"),
            ("IS1SP360-C-BL", "PR-23060-00"),
            ("IS1SP360-C-BL-10", "PR-23060-10"),
        ]
    );
    assert_eq!(
        articles("is2"),
        [
            ("IS2BP090-C-CL", "PR-23054-30"),
            ("IS2MA090-C-BL", "PR-25004-00"),
            ("IS2BP090-C-BL", "PR-25054-30"),
            ("IS2SP090-C-BL", "PR-23064-00"),
            ("IS2SP090-C-BL-10", "PR-23064-10"),
        ]
    );
}
