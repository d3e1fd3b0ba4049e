// Small helpers to make a page's elements.

type Attributes = { [name: string]: string | number | boolean | undefined };

export function element<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Attributes = {},
  ...children: (Node | string)[]
): HTMLElementTagNameMap[K] {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === true) made.setAttribute(name, "");
    else if (value !== undefined && value !== false) made.setAttribute(name, String(value));
  }
  made.append(...children);
  return made;
}

export function byId<T extends Element = HTMLElement>(id: string): T {
  const found = document.getElementById(id);
  if (!found) throw new Error(`the page has no #${id}`);
  return found as unknown as T;
}

/** Shows a number, in words, in its place. */
export function show(id: string, value: number, words: string): void {
  const place = byId<HTMLDataElement>(id);
  place.value = String(value);
  if (place.textContent !== words) place.textContent = words;
}

/** A colour of the style sheet, which differs from dark to light. */
export function colour(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

/** A name of a field as a person reads it: without its unit, which stands beside it. */
export function label(name: string): string {
  return name
    .replace(/_(nm_s_per_rad|nm_per_rad|nm_per_s|nm_per_a|v_per_a|kg_m2|rad_s2|rad_s|rad|nm|deg|hz|ohm|s|a|v|h)$/, "")
    .replaceAll("_", " ");
}

/** Hands a file to the user. */
export function saveFile(content: Blob, name: string): void {
  const link = element("a", { href: URL.createObjectURL(content), download: name });
  link.click();
  // Not before the browser has begun to read it.
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}
