// Entries of docs/reference/troubleshooting.md about a fault, to unfold beside it.

import troubleshooting from "../../docs/reference/troubleshooting.md";
import { element } from "./page";

/** Paragraphs of an entry without marks of its language; none if there is no such entry. */
function paragraphs(name: string): string[] {
  const entry = troubleshooting.split(/^#+ /m).find((part) => part.startsWith(`${name}\n`)) ?? "";
  return entry
    .slice(name.length)
    .split(/\n\s*\n|\n(?=(?:-|\d+\.) )/) // an item of a list is a paragraph
    .map((text) => text.replace(/\[([^\]]*)\]\([^)]*\)/g, "$1").replace(/^- |[`*]/g, "").replace(/\s+/g, " ").trim())
    .filter((text) => text !== "");
}

/** The entry, folded; on the documents' site with a link to it. */
export function entryOf(fault: string): HTMLElement[] {
  const said = paragraphs(fault).map((text) => element("p", {}, text));
  const site = document.querySelector<HTMLMetaElement>("meta[name=documents]")?.content;
  if (site) {
    const href = `${site}reference/troubleshooting.html#${fault.replaceAll("_", "-")}`;
    said.push(element("p", {}, element("a", { href, target: "_top" }, "in the documents")));
  }
  return said.length ? [element("details", {}, element("summary", {}, "what it means and what to do"), ...said)] : [];
}
