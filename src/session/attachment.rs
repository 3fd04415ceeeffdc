//! Names and bytes of attachments in the file: matrices and tables are compressed, which MCAP does for messages only.

use std::borrow::Cow;
use std::io::Read as _;

use super::records::{MOST_CHUNK, MOST_RATIO, MOST_RECORD};

/// Follows the name of what is compressed.
const SUFFIX: &str = ".zst";
/// What is compressed.
const NUMBERS: &str = ".bin";
/// Level of zstd: higher ones save 2 % and take ten times as long.
const LEVEL: i32 = 3;

/// Name, media type and bytes as stored.
///
/// # Errors
/// None that is known: zstd reports one where it has no memory.
pub(super) fn stored<'a>(
    name: &str,
    bytes: &'a [u8],
) -> std::io::Result<(String, &'static str, Cow<'a, [u8]>)> {
    if name.ends_with(NUMBERS) {
        let compressed = zstd::stream::encode_all(bytes, LEVEL)?;
        return Ok((
            format!("{name}{SUFFIX}"),
            "application/zstd",
            compressed.into(),
        ));
    }
    let media_type = match name.rsplit_once('.') {
        Some((_, "json")) => "application/json",
        Some((_, "toml")) => "application/toml",
        _ => "application/octet-stream",
    };
    Ok((name.to_owned(), media_type, bytes.into()))
}

/// Name and bytes of what is stored; `None` if it is damaged, or larger than any matrix or table. The first version compressed
/// nothing.
pub(super) fn restored<'a>(name: &'a str, bytes: &'a [u8]) -> Option<(&'a str, Cow<'a, [u8]>)> {
    let Some(name) = name.strip_suffix(SUFFIX) else {
        return Some((name, bytes.into()));
    };
    let most = (bytes.len() as u64)
        .saturating_mul(MOST_RATIO)
        .clamp(MOST_CHUNK as u64, MOST_RECORD as u64);
    let mut whole = Vec::new();
    let mut decoder = zstd::stream::read::Decoder::new(bytes).ok()?.take(most + 1);
    decoder.read_to_end(&mut whole).ok()?;
    (whole.len() as u64 <= most).then_some((name, whole.into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_compressed_and_texts_are_not() {
        let bytes = vec![7; 100_000];
        let (name, media_type, packed) = stored("sensing-1.bin", &bytes).expect("memory");
        assert_eq!(
            (name.as_str(), media_type),
            ("sensing-1.bin.zst", "application/zstd")
        );
        assert!(packed.len() < 1000);
        let (name, back) = restored(&name, &packed).expect("sound");
        assert_eq!((name, back.as_ref()), ("sensing-1.bin", bytes.as_slice()));
        let (name, _, text) = stored("pad.toml", b"name = 1").expect("memory");
        assert_eq!(
            (name.as_str(), text.as_ref()),
            ("pad.toml", b"name = 1".as_slice())
        );
    }

    #[test]
    fn a_bomb_and_a_cut_are_damage() {
        let zeros = vec![0; MOST_RECORD + 1];
        let bomb = zstd::stream::encode_all(zeros.as_slice(), LEVEL).expect("memory");
        assert_eq!(restored("responses.bin.zst", &bomb), None);
        let (name, _, packed) = stored("sensing.bin", &[1, 2, 3, 4]).expect("memory");
        assert_eq!(restored(&name, &packed[..packed.len() - 2]), None);
        assert_eq!(restored(&name, b"no zstd"), None);
    }
}
