// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

namespace hybrid::map_schema {

/// "HMAP" in ASCII: the application id in the header of the file.
inline constexpr int kApplicationId = 0x484d4150;
/// The user version in the header: raised with every change of the tables. Files of earlier
/// versions are read, and changed by the first transaction.
inline constexpr int kVersion = 7;
/// The version from which on files have a checksum.
inline constexpr int kFirstWithChecksum = 3;
/// The version from which on files have local maps.
inline constexpr int kFirstWithScans = 4;
/// The version from which on files say what landmarks stand for.
inline constexpr int kFirstWithSizes = 5;
/// The version from which on files have clouds.
inline constexpr int kFirstWithClouds = 6;
/// The version from which on files tell how well local maps are known beside each other.
inline constexpr int kFirstWithParents = 7;

/// The tables of docs/map_format.md but for those of later versions.
inline constexpr const char* kTables = R"(
CREATE TABLE map (
  name TEXT PRIMARY KEY, value NOT NULL) WITHOUT ROWID;
CREATE TABLE class (
  number INTEGER PRIMARY KEY, name TEXT NOT NULL);
CREATE TABLE session (
  id INTEGER PRIMARY KEY, mode TEXT NOT NULL, complete INTEGER NOT NULL, version TEXT NOT NULL,
  command TEXT NOT NULL, configuration TEXT NOT NULL);
CREATE TABLE input (
  session INTEGER NOT NULL REFERENCES session(id), number INTEGER NOT NULL, path TEXT NOT NULL,
  sha256 TEXT NOT NULL, PRIMARY KEY (session, number)) WITHOUT ROWID;
CREATE TABLE keyframe (
  session INTEGER NOT NULL REFERENCES session(id), number INTEGER NOT NULL, row INTEGER NOT NULL,
  time REAL NOT NULL, x REAL NOT NULL, y REAL NOT NULL, z REAL NOT NULL,
  qx REAL NOT NULL, qy REAL NOT NULL, qz REAL NOT NULL, qw REAL NOT NULL,
  robot INTEGER NOT NULL DEFAULT 0, PRIMARY KEY (session, number)) WITHOUT ROWID;
CREATE TABLE robot (
  session INTEGER NOT NULL REFERENCES session(id), number INTEGER NOT NULL, name TEXT NOT NULL,
  PRIMARY KEY (session, number)) WITHOUT ROWID;
CREATE TABLE landmark (
  id INTEGER PRIMARY KEY, session INTEGER NOT NULL REFERENCES session(id),
  x REAL NOT NULL, y REAL NOT NULL, z REAL NOT NULL,
  xx REAL NOT NULL, xy REAL NOT NULL, xz REAL NOT NULL,
  yy REAL NOT NULL, yz REAL NOT NULL, zz REAL NOT NULL,
  existence REAL NOT NULL, sightings INTEGER NOT NULL);
CREATE TABLE landmark_class (
  landmark INTEGER NOT NULL REFERENCES landmark(id), class INTEGER NOT NULL REFERENCES class(number),
  probability REAL NOT NULL, PRIMARY KEY (landmark, class)) WITHOUT ROWID;
CREATE TABLE prior (
  landmark INTEGER NOT NULL REFERENCES landmark(id), number INTEGER NOT NULL,
  given INTEGER NOT NULL REFERENCES landmark(id),
  r11 REAL NOT NULL, r12 REAL NOT NULL, r13 REAL NOT NULL,
  r21 REAL NOT NULL, r22 REAL NOT NULL, r23 REAL NOT NULL,
  r31 REAL NOT NULL, r32 REAL NOT NULL, r33 REAL NOT NULL,
  PRIMARY KEY (landmark, number)) WITHOUT ROWID;
CREATE TABLE draft (
  landmark INTEGER PRIMARY KEY, x REAL NOT NULL, y REAL NOT NULL, z REAL NOT NULL,
  class INTEGER, sightings INTEGER NOT NULL);
)";

/// The tables of laser scans, which versions before kFirstWithScans lack.
inline constexpr const char* kScanTables = R"(
CREATE TABLE local_map (
  session INTEGER NOT NULL REFERENCES session(id), number INTEGER NOT NULL,
  x REAL NOT NULL, y REAL NOT NULL, angle REAL NOT NULL,
  xx REAL NOT NULL, xy REAL NOT NULL, xa REAL NOT NULL,
  yy REAL NOT NULL, ya REAL NOT NULL, aa REAL NOT NULL,
  PRIMARY KEY (session, number)) WITHOUT ROWID;
CREATE TABLE surface (
  session INTEGER NOT NULL, map INTEGER NOT NULL, number INTEGER NOT NULL,
  x INTEGER NOT NULL, y INTEGER NOT NULL, direction INTEGER,
  PRIMARY KEY (session, map, number),
  FOREIGN KEY (session, map) REFERENCES local_map(session, number)) WITHOUT ROWID;
)";
/// The table of clouds, which versions before kFirstWithClouds lack.
inline constexpr const char* kCloudTable = R"(
CREATE TABLE local_cloud (
  session INTEGER NOT NULL REFERENCES session(id), number INTEGER NOT NULL,
  x REAL NOT NULL, y REAL NOT NULL, z REAL NOT NULL,
  qx REAL NOT NULL, qy REAL NOT NULL, qz REAL NOT NULL, qw REAL NOT NULL,
  covariance BLOB NOT NULL, spacing REAL NOT NULL, points BLOB NOT NULL,
  PRIMARY KEY (session, number));
)";
/// The table of local maps that are known beside others: of laser scans in a map in the plane, of
/// clouds in space. Versions before kFirstWithParents lack it.
inline constexpr const char* kParentTable = R"(
CREATE TABLE place_parent (
  session INTEGER NOT NULL REFERENCES session(id), number INTEGER NOT NULL,
  parent_session INTEGER NOT NULL, parent INTEGER NOT NULL, covariance BLOB NOT NULL,
  PRIMARY KEY (session, number)) WITHOUT ROWID;
)";
/// The table of landmarks that are not single things without an extent, which versions before
/// kFirstWithSizes lack.
inline constexpr const char* kSizeTable = R"(
CREATE TABLE landmark_size (
  landmark INTEGER PRIMARY KEY REFERENCES landmark(id),
  extent REAL NOT NULL, things INTEGER NOT NULL);
)";
/// Makes the tables of version 1, which knew of one robot a session, those of later versions.
inline constexpr const char* kFromVersion1 = R"(
ALTER TABLE keyframe ADD COLUMN robot INTEGER NOT NULL DEFAULT 0;
CREATE TABLE robot (
  session INTEGER NOT NULL REFERENCES session(id), number INTEGER NOT NULL, name TEXT NOT NULL,
  PRIMARY KEY (session, number)) WITHOUT ROWID;
)";
/// The reverse.
inline constexpr const char* kToVersion1 = R"(
DROP TABLE robot;
ALTER TABLE keyframe DROP COLUMN robot;
)";

}  // namespace hybrid::map_schema
