// The udev rule, which the bundler puts in as text.
declare module "*.rules" {
  const text: string;
  export default text;
}
