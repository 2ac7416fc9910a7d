// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/plugin_tag.h"

#include <elf.h>
#include <link.h>

#include <algorithm>
#include <cstring>

namespace hybrid {
namespace {

constexpr char kTagName[] = "hybrid_plugin_abi";
constexpr std::string_view kTagText(kTagName, sizeof(kTagName));  // with the zero at its end

/// The bytes from `offset` on, at most `size`; fewer at the end of the file.
std::string_view part(std::string_view file, std::uint64_t offset, std::uint64_t size) {
  return file.substr(std::min<std::uint64_t>(offset, file.size()), size);
}

/// A structure of the file; zeros beyond its end.
template <class T>
T read_at(std::string_view file, std::uint64_t offset) {
  T out{};
  const std::string_view bytes = part(file, offset, sizeof(T));
  if (bytes.size() == sizeof(T)) std::memcpy(&out, bytes.data(), sizeof(T));
  return out;
}

/// Row of a table in the file.
template <class T>
T row(std::string_view file, std::uint64_t table, std::uint64_t index) {
  return read_at<T>(file, table + index * sizeof(T));
}

bool is_library(const ElfW(Ehdr) & header) {
  return std::memcmp(header.e_ident, ELFMAG, SELFMAG) == 0 && header.e_type == ET_DYN &&
         header.e_ident[EI_CLASS] == (sizeof(void*) == 8 ? ELFCLASS64 : ELFCLASS32) &&
         header.e_ident[EI_DATA] ==
             (__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__ ? ELFDATA2LSB : ELFDATA2MSB);
}

/// The table of symbols for the loader; zeros if there is none.
ElfW(Shdr) symbol_table(std::string_view file, const ElfW(Ehdr) & header) {
  for (std::uint64_t i = 0; i < header.e_shnum; ++i) {
    const auto section = row<ElfW(Shdr)>(file, header.e_shoff, i);
    if (section.sh_type == SHT_DYNSYM) return section;
  }
  return {};
}

/// What is loaded to an address; empty if the file has nothing for it.
std::string_view bytes_at(std::string_view file, const ElfW(Ehdr) & header, std::uint64_t address) {
  for (std::uint64_t i = 0; i < header.e_phnum; ++i) {
    const auto segment = row<ElfW(Phdr)>(file, header.e_phoff, i);
    const std::uint64_t within = address - segment.p_vaddr;
    if (segment.p_type != PT_LOAD || address < segment.p_vaddr || within >= segment.p_filesz) {
      continue;
    }
    return part(part(file, segment.p_offset, segment.p_filesz), within, sizeof(PluginAbi));
  }
  return {};
}

}  // namespace

std::optional<PluginAbi> find_plugin_tag(std::string_view library) {
  const auto header = read_at<ElfW(Ehdr)>(library, 0);
  if (!is_library(header)) return std::nullopt;
  const auto table = symbol_table(library, header);
  const auto names = row<ElfW(Shdr)>(library, header.e_shoff, table.sh_link);
  const std::string_view symbols = part(library, table.sh_offset, table.sh_size);
  for (std::uint64_t i = 0; i < symbols.size() / sizeof(ElfW(Sym)); ++i) {
    const auto symbol = row<ElfW(Sym)>(symbols, 0, i);
    if (symbol.st_shndx == SHN_UNDEF ||
        part(library, names.sh_offset + symbol.st_name, sizeof(kTagName)) != kTagText) {
      continue;
    }
    const std::string_view bytes = bytes_at(library, header, symbol.st_value);
    PluginAbi tag;
    if (bytes.size() < sizeof(tag.bytes)) return std::nullopt;
    const auto size = read_at<std::uint32_t>(bytes, 0);
    std::memcpy(&tag, bytes.data(), std::min<std::size_t>(size, bytes.size()));
    return tag;
  }
  return std::nullopt;
}

}  // namespace hybrid
