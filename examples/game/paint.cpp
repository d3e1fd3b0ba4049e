#include "game/paint.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <numbers>
#include <vector>

namespace game {
namespace {

/// Strokes of each character on a grid of 5 by 7: two digits are a point, column and row.
struct Glyph {
  char character;
  std::array<std::string_view, 3> strokes;
};
constexpr Glyph kGlyphs[] = {
    {'A', {"062046", "1434"}},
    {'B', {"06003041423303", "3344453606"}},
    {'C', {"4130100105163645"}},
    {'D', {"00062644422000"}},
    {'E', {"40000646", "0333"}},
    {'F', {"400006", "0333"}},
    {'G', {"41301001051636454323"}},
    {'H', {"0006", "4046", "0343"}},
    {'I', {"1030", "2026", "1636"}},
    {'J', {"4045361605"}},
    {'K', {"0006", "400346"}},
    {'L', {"000646"}},
    {'M', {"0600234046"}},
    {'N', {"06004640"}},
    {'O', {"103041453616050110"}},
    {'P', {"06003041423303"}},
    {'Q', {"103041453616050110", "2446"}},
    {'R', {"06003041423303", "2346"}},
    {'S', {"413010010213334445361605"}},
    {'T', {"0040", "2026"}},
    {'U', {"000516364540"}},
    {'V', {"002640"}},
    {'W', {"0016233640"}},
    {'X', {"0046", "4006"}},
    {'Y', {"002340", "2326"}},
    {'Z', {"00400646"}},
    {'0', {"103041453616050110"}},
    {'1', {"112026", "1636"}},
    {'2', {"01103041420646"}},
    {'3', {"004023334445361605"}},
    {'4', {"36300444"}},
    {'5', {"400003334445361605"}},
    {'6', {"4130100105163645443303"}},
    {'7', {"004016"}},
    {'8', {"130201103041423313", "130405163645443313"}},
    {'9', {"0516364541301001021343"}},
    {'.', {"2626"}},
    {',', {"2617"}},
    {':', {"2222", "2525"}},
    {';', {"2222", "2516"}},
    {'-', {"1333"}},
    {'+', {"1333", "2224"}},
    {'/', {"0640"}},
    {'!', {"2023", "2626"}},
    {'\'', {"2021"}},
    {'(', {"30111536"}},
    {')', {"10313516"}},
};

const Glyph* find_glyph(char character) {
  const char capital = static_cast<char>(std::toupper(static_cast<unsigned char>(character)));
  const auto* end = std::end(kGlyphs);
  const auto* found = std::find_if(std::begin(kGlyphs), end, [capital](const Glyph& glyph) {
    return glyph.character == capital;
  });
  return found == end ? nullptr : found;
}

Uint8 mix(Uint8 a, Uint8 b, float share) {
  return static_cast<Uint8>(std::lround((1 - share) * a + share * b));
}

}  // namespace

SDL_FPoint around(SDL_FPoint centre, float radius, float angle_deg) {
  const float angle = angle_deg * std::numbers::pi_v<float> / 180;
  return {centre.x + radius * std::sin(angle), centre.y - radius * std::cos(angle)};
}

void Paint::shape(std::span<const SDL_FPoint> outline, SDL_Color top, SDL_Color bottom) {
  const auto [high, low] =
      std::minmax_element(outline.begin(), outline.end(),
                          [](const SDL_FPoint& a, const SDL_FPoint& b) { return a.y < b.y; });
  std::vector<SDL_Vertex> vertices;
  for (const SDL_FPoint& point : outline) {
    const float share = (point.y - high->y) / std::max(low->y - high->y, 1e-3F);
    vertices.push_back({point,
                        {mix(top.r, bottom.r, share), mix(top.g, bottom.g, share),
                         mix(top.b, bottom.b, share), mix(top.a, bottom.a, share)},
                        {}});
  }
  std::vector<int> fan;
  for (int i = 2; i < static_cast<int>(vertices.size()); ++i) {
    fan.insert(fan.end(), {0, i - 1, i});
  }
  SDL_RenderGeometry(renderer_, nullptr, vertices.data(), static_cast<int>(vertices.size()),
                     fan.data(), static_cast<int>(fan.size()));
}

void Paint::box(SDL_FRect box, float radius, SDL_Color top, SDL_Color bottom) {
  radius = std::min({radius, box.w / 2, box.h / 2});
  const std::array<SDL_FPoint, 4> corners{{{box.x + box.w - radius, box.y + radius},
                                           {box.x + box.w - radius, box.y + box.h - radius},
                                           {box.x + radius, box.y + box.h - radius},
                                           {box.x + radius, box.y + radius}}};
  const int steps = radius < 1 ? 0 : 6;
  std::vector<SDL_FPoint> outline;
  for (int corner = 0; corner < 4; ++corner) {
    for (int i = 0; i <= steps; ++i) {
      const float share = steps == 0 ? 0.5F : static_cast<float>(i) / static_cast<float>(steps);
      outline.push_back(around(corners[static_cast<std::size_t>(corner)], radius,
                               90 * (static_cast<float>(corner) + share)));
    }
  }
  shape(outline, top, bottom);
}

void Paint::disc(SDL_FPoint centre, float radius, SDL_Color top, SDL_Color bottom) {
  const int corners = radius < 6 ? 12 : 64;
  std::vector<SDL_FPoint> outline;
  for (int i = 0; i < corners; ++i) {
    outline.push_back(
        around(centre, radius, 360 * static_cast<float>(i) / static_cast<float>(corners)));
  }
  shape(outline, top, bottom);
}

void Paint::line(std::span<const SDL_FPoint> points, float width, SDL_Color colour) {
  const float half = width / 2;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (colour.a == 255) disc(points[i], half, colour);  // ends would show through
    if (i == 0) continue;
    const SDL_FPoint a = points[i - 1];
    const SDL_FPoint b = points[i];
    const float length = std::hypot(b.x - a.x, b.y - a.y);
    if (length == 0) continue;
    const float x = half * (a.y - b.y) / length;
    const float y = half * (b.x - a.x) / length;
    shape({{a.x + x, a.y + y}, {b.x + x, b.y + y}, {b.x - x, b.y - y}, {a.x - x, a.y - y}}, colour);
  }
}

void Paint::arc(SDL_FPoint centre, float radius, float from_deg, float to_deg, float width,
                SDL_Color colour) {
  std::vector<SDL_FPoint> points;
  const int steps = 1 + static_cast<int>(std::abs(to_deg - from_deg) / 4);
  for (int i = 0; i <= steps; ++i) {
    const float share = static_cast<float>(i) / static_cast<float>(steps);
    points.push_back(around(centre, radius, from_deg + share * (to_deg - from_deg)));
  }
  line(points, width, colour);
}

void Paint::text(std::string_view text, SDL_FPoint at, float height, SDL_Color colour,
                 Align align) {
  const float unit = height / 6;
  const float advance = 6 * unit;
  const float width = advance * static_cast<float>(text.size()) - 2 * unit;
  if (align == Align::centre) at.x -= width / 2;
  if (align == Align::right) at.x -= width;
  for (const char character : text) {
    if (const Glyph* glyph = find_glyph(character)) {
      for (const std::string_view stroke : glyph->strokes) {
        std::vector<SDL_FPoint> points;
        for (std::size_t i = 0; i + 1 < stroke.size(); i += 2) {
          points.push_back({at.x + unit * static_cast<float>(stroke[i] - '0'),
                            at.y + unit * static_cast<float>(stroke[i + 1] - '0')});
        }
        line(points, std::max(1.2F, 0.75F * unit), colour);
      }
    }
    at.x += advance;
  }
}

}  // namespace game
