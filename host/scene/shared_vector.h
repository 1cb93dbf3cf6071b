// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <initializer_list>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace eikon {

/// A vector whose copies share its elements until one of them is changed. Primitives of a file that
/// name the same accessors are such copies.
template <class T>
class SharedVector {
 public:
  SharedVector() = default;
  SharedVector(std::vector<T> elements) : elements_(std::make_shared<std::vector<T>>(std::move(elements))) {}
  SharedVector(std::initializer_list<T> elements) : SharedVector(std::vector<T>(elements)) {}

  [[nodiscard]] const std::vector<T>& all() const { return elements_ ? *elements_ : none(); }
  operator const std::vector<T>&() const { return all(); }
  [[nodiscard]] bool empty() const { return all().empty(); }
  [[nodiscard]] std::size_t size() const { return all().size(); }
  [[nodiscard]] const T* data() const { return all().data(); }
  [[nodiscard]] std::size_t capacity() const { return all().capacity(); }
  [[nodiscard]] const T& operator[](std::size_t i) const { return (*elements_)[i]; }
  [[nodiscard]] const T& at(std::size_t i) const { return all().at(i); }
  [[nodiscard]] auto begin() const { return all().begin(); }
  [[nodiscard]] auto end() const { return all().end(); }

  /// Who keeps the elements, and a vector that shares them with an owner; nothing without one.
  [[nodiscard]] const std::shared_ptr<std::vector<T>>& owner() const { return elements_; }
  [[nodiscard]] static std::optional<SharedVector> shared(std::shared_ptr<std::vector<T>> owner) {
    if (owner == nullptr) return std::nullopt;
    SharedVector result;
    result.elements_ = std::move(owner);
    return result;
  }

  /// The elements to change, which are copied first if others share them.
  [[nodiscard]] std::vector<T>& edit() {
    if (!elements_)
      elements_ = std::make_shared<std::vector<T>>();
    else if (elements_.use_count() > 1)
      elements_ = std::make_shared<std::vector<T>>(*elements_);
    return *elements_;
  }
  /// Moves the elements out, or copies them if others share them.
  [[nodiscard]] std::vector<T> take() {
    std::vector<T> taken = std::move(edit());
    elements_.reset();
    return taken;
  }

  // What changes elements, as vectors have it.
  [[nodiscard]] T& operator[](std::size_t i) { return edit()[i]; }
  [[nodiscard]] auto begin() { return edit().begin(); }
  [[nodiscard]] auto end() { return edit().end(); }
  void push_back(const T& element) { edit().push_back(element); }
  template <class... Args>
  void emplace_back(Args&&... args) {
    edit().emplace_back(std::forward<Args>(args)...);
  }
  void assign(std::size_t count, const T& element) { edit().assign(count, element); }
  void resize(std::size_t count) { edit().resize(count); }
  void clear() { elements_.reset(); }

  friend bool operator==(const SharedVector& a, const SharedVector& b) {
    return a.elements_ == b.elements_ || a.all() == b.all();
  }

 private:
  static const std::vector<T>& none() {
    static const std::vector<T> empty;
    return empty;
  }

  std::shared_ptr<std::vector<T>> elements_;  // null: none
};

}  // namespace eikon
