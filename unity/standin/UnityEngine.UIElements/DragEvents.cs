// What is dragged over elements in the editor, and dropped on them.
namespace UnityEngine.UIElements
{
    public abstract class MouseEventBase<T> : EventBase<T> where T : MouseEventBase<T>, new()
    {
        public Vector2 mousePosition { get; protected internal set; }
        public EventModifiers modifiers { get; protected internal set; }
        public Vector2 localMousePosition => mousePosition - (((currentTarget ?? target) as VisualElement)?.worldBound.position ?? default);
    }

    public abstract class DragAndDropEventBase<T> : MouseEventBase<T> where T : DragAndDropEventBase<T>, new() { }

    public sealed class DragEnterEvent : DragAndDropEventBase<DragEnterEvent> { public DragEnterEvent() { bubbles = false; } }
    public sealed class DragLeaveEvent : DragAndDropEventBase<DragLeaveEvent> { public DragLeaveEvent() { bubbles = false; } }
    public sealed class DragUpdatedEvent : DragAndDropEventBase<DragUpdatedEvent> { }
    public sealed class DragPerformEvent : DragAndDropEventBase<DragPerformEvent> { }
    public sealed class DragExitedEvent : DragAndDropEventBase<DragExitedEvent> { }
}
