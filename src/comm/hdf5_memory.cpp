#include "comm/hdf5_memory.hpp"

#include <algorithm>
#include <cstring>

namespace berm {
namespace {

/// A file as the driver sees it; HDF5 owns the part in front.
struct OpenFile {
  H5FD_t by_hdf5;
  Hdf5Memory* memory;
};

Hdf5Memory& memory_of(const H5FD_t* file) { return *reinterpret_cast<const OpenFile*>(file)->memory; }

H5FD_t* open_file(const char*, unsigned, hid_t access, haddr_t) {
  const auto* memory = static_cast<Hdf5Memory* const*>(H5Pget_driver_info(access));
  if (!memory) return nullptr;
  return reinterpret_cast<H5FD_t*>(new OpenFile{{}, *memory});
}

herr_t close_file(H5FD_t* file) {
  delete reinterpret_cast<OpenFile*>(file);
  return 0;
}

herr_t say_features(const H5FD_t*, unsigned long* flags) {
  if (flags) *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_AGGREGATE_SMALLDATA | H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
  return 0;
}

haddr_t end_of_room(const H5FD_t* file, H5FD_mem_t) { return memory_of(file).room; }

herr_t set_end_of_room(H5FD_t* file, H5FD_mem_t, haddr_t end) {
  memory_of(file).room = end;
  return 0;
}

herr_t read_bytes(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t size, void* bytes) {
  memory_of(file).read(at, {static_cast<char*>(bytes), size});
  return 0;
}

herr_t write_bytes(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t size, const void* bytes) {
  memory_of(file).write(at, {static_cast<const char*>(bytes), size});
  return 0;
}

H5FD_class_t driver_class() {
  H5FD_class_t c{};
  c.name = "berm_memory";
  c.maxaddr = ~haddr_t(0) >> 2;
  c.fc_degree = H5F_CLOSE_STRONG;
  c.fapl_size = sizeof(Hdf5Memory*);
  c.open = open_file;
  c.close = close_file;
  c.query = say_features;
  c.get_eoa = end_of_room;
  c.set_eoa = set_end_of_room;
  c.get_eof = end_of_room;
  c.read = read_bytes;
  c.write = write_bytes;
  const H5FD_mem_t lists[] = H5FD_FLMAP_DICHOTOMY;
  std::copy(std::begin(lists), std::end(lists), c.fl_map);
  return c;
}

}  // namespace

void Hdf5Memory::write(std::uint64_t at, std::span<const char> bytes) {
  if (bytes.empty()) return;
  written_.push_back({at, at + bytes.size()});
  while (!bytes.empty()) {
    const std::uint64_t begin = at % page_size, n = std::min(page_size - begin, std::uint64_t(bytes.size()));
    std::memcpy(pages_[at / page_size].data() + begin, bytes.data(), n);  // a new page is zero
    at += n;
    bytes = bytes.subspan(n);
  }
}

void Hdf5Memory::read(std::uint64_t at, std::span<char> bytes) const {
  while (!bytes.empty()) {
    const std::uint64_t begin = at % page_size, n = std::min(page_size - begin, std::uint64_t(bytes.size()));
    const auto page = pages_.find(at / page_size);
    if (page == pages_.end())
      std::memset(bytes.data(), 0, n);
    else
      std::memcpy(bytes.data(), page->second.data() + begin, n);
    at += n;
    bytes = bytes.subspan(n);
  }
}

void Hdf5Memory::for_each_part(const std::function<void(std::uint64_t, std::span<const char>)>& use) const {
  std::vector<Range> ranges = written_;
  std::sort(ranges.begin(), ranges.end(), [](const Range& a, const Range& b) { return a.begin < b.begin; });
  std::uint64_t done = 0;
  std::vector<char> bytes;
  for (const Range& r : ranges) {
    const std::uint64_t begin = std::max(r.begin, done);
    if (begin >= r.end) continue;
    bytes.resize(r.end - begin);
    read(begin, bytes);
    use(begin, bytes);
    done = r.end;
  }
}

hid_t access_to_memory(Hdf5Memory& memory) {
  static const H5FD_class_t description = driver_class();
  static hid_t driver = H5I_INVALID_HID;
  if (H5Iis_valid(driver) <= 0) driver = H5FDregister(&description);
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  Hdf5Memory* const where = &memory;
  if (driver < 0 || access < 0 || H5Pset_driver(access, driver, &where) < 0) return H5I_INVALID_HID;
  return access;
}

}  // namespace berm
