//! How alike words are: what was misspelt is told with the name that was meant.

/// Letters to insert, to leave out or to exchange to make one word of another: Levenshtein's distance.
pub fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, &cb) in b.iter().enumerate() {
            let replace = diagonal + usize::from(ca != cb);
            diagonal = row[j + 1];
            row[j + 1] = replace.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_are_inserted_left_out_and_exchanged() {
        for (a, b, distance) in [
            ("", "", 0),
            ("", "lung", 4),
            ("Lung", "lungs", 2),
            ("kitten", "sitting", 3),
            ("Größe", "Grösse", 2),
        ] {
            assert_eq!((edit_distance(a, b), edit_distance(b, a)), (distance, distance), "{a}, {b}");
        }
    }
}
