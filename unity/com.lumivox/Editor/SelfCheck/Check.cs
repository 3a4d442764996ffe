using System;
using System.Collections;
using System.Collections.Generic;

namespace Lumivox.Editor
{
    /// <summary>One thing that is checked, and what came of it.</summary>
    internal sealed class Check
    {
        public enum State { Waiting, Running, Passed, Failed }

        /// <summary>What is wrong, and what to do about it.</summary>
        public readonly struct Fault
        {
            public readonly string What, Remedy;

            public Fault(string what, string remedy) => (What, Remedy) = (what, remedy);
        }

        readonly Func<Check, IEnumerator> work;

        public readonly string Name;
        public State Now;
        public double Seconds;
        public readonly List<string> Notes = new List<string>();
        public readonly List<Fault> Faults = new List<Fault>();
        /// <summary>Files that it wrote: what was seen, what was expected, and where they differ.</summary>
        public string[] Pictures = Array.Empty<string>();

        /// <summary>Work that goes on a little in each turn of the editor.</summary>
        public Check(string name, Func<Check, IEnumerator> work) => (Name, this.work) = (name, work);

        /// <summary>Work that is done at once.</summary>
        public Check(string name, Action<Check> work) : this(name, check => Once(check, work))
        {
        }

        static IEnumerator Once(Check check, Action<Check> work)
        {
            work(check);
            yield break;
        }

        public IEnumerator Begin() => work(this);

        public void Note(string what) => Notes.Add(what);

        public void Fail(string what, string remedy = "") => Faults.Add(new Fault(what, remedy));
    }
}
