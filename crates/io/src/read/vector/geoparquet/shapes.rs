//! Types of the fields of Parquet's descriptions, in the order of their numbers.
//!
//! # References
//! Apache Parquet format 2.12, `parquet.thrift`.

use super::compact::Shape::{self, Any, Byte, Bytes, Double, List, Number, Struct, Truth};

/// `FileMetaData`.
pub(super) const DESCRIPTION: [Shape; 7] = [
    Number,
    List(&Struct(&ELEMENT)),
    Number,
    List(&Struct(&GROUP)),
    List(&Struct(&[Bytes, Bytes])),
    Bytes,
    List(&Struct(&[Struct(&[])])),
];

/// `SchemaElement`.
const ELEMENT: [Shape; 10] =
    [Number, Number, Number, Bytes, Number, Number, Number, Number, Number, Struct(&LOGICAL_TYPE)];

/// `LogicalType`, of which a file has one field.
const LOGICAL_TYPE: [Shape; 19] = [
    Struct(&[]),
    Struct(&[]),
    Struct(&[]),
    Struct(&[]),
    Struct(&[Number, Number]),
    Struct(&[]),
    Struct(&MOMENT),
    Struct(&MOMENT),
    Any,
    Struct(&[Byte, Truth]),
    Struct(&[]),
    Struct(&[]),
    Struct(&[]),
    Struct(&[]),
    Struct(&[]),
    Struct(&[Byte]),
    Struct(&[Bytes]),
    Struct(&[Bytes, Number]),
    Struct(&[]),
];

/// `TimeType` and `TimestampType`: whether it is of UTC, and milli-, micro- or nanoseconds.
const MOMENT: [Shape; 2] = [Truth, Struct(&[Struct(&[]), Struct(&[]), Struct(&[])])];

/// `RowGroup`.
const GROUP: [Shape; 7] =
    [List(&Struct(&CHUNK)), Number, Number, List(&Struct(&[Number, Truth, Truth])), Number, Number, Number];

/// `ColumnChunk`.
const CHUNK: [Shape; 7] = [Bytes, Number, Struct(&COLUMN), Number, Number, Number, Number];

/// `ColumnMetaData`.
const COLUMN: [Shape; 17] = [
    Number,
    List(&Number),
    List(&Bytes),
    Number,
    Number,
    Number,
    Number,
    List(&Struct(&[Bytes, Bytes])),
    Number,
    Number,
    Number,
    Struct(&STATISTICS),
    List(&Struct(&[Number, Number, Number])),
    Number,
    Number,
    Struct(&[Number, List(&Number), List(&Number)]),
    Struct(&[Struct(&[Double, Double, Double, Double, Double, Double, Double, Double]), List(&Number)]),
];

/// `Statistics`.
const STATISTICS: [Shape; 9] = [Bytes, Bytes, Number, Number, Bytes, Bytes, Truth, Truth, Number];

/// `PageHeader`.
pub(super) const PAGE: [Shape; 8] = [
    Number,
    Number,
    Number,
    Number,
    Struct(&[Number, Number, Number, Number, Struct(&STATISTICS)]),
    Struct(&[]),
    Struct(&[Number, Number, Truth]),
    Struct(&[Number, Number, Number, Number, Number, Number, Truth, Struct(&STATISTICS)]),
];
